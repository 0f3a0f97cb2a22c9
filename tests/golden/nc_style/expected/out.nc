%
(corrected by trunnion: model 7d1b17416727, machine Middle-size trunnion, serial 0001)
; no header but ours
N1 g21g90 (metric)
n2 g0 x+10.5021 y 19.9978 z.5019 a-040.0008 c6.9999
N3 G1X11.0021Y-.2522Z.5016F0500 ; feed
N4	X12.0021	Y-0.0022 Z.5017

N5 M8 (coolant)
N6 G01 Z0.0017
M2
left alone ?? X#1
