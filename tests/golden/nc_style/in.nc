%
; no header but ours
N1 g21g90 (metric)
n2 g0 x+10.50 y 2 0 z.5 a-040.0 c7
N3 G1X11.Y-.25F0500 ; feed
N4	X12	Y0

N5 M8 (coolant)
N6 G01 Z-0.0
M2
left alone ?? X#1
