%
O8
(corrected by trunnion: model 7d1b17416727, machine Middle-size trunnion, serial 0001)
G21 G90 G54.1 P2
G0 A-40. C30.
G43.4 H1 X20.0027 Y14.9955 Z80.0026 A-40.0009 C29.9999
G1 Z40.0026 X20.003 Y14.996 F500.
M30
%
