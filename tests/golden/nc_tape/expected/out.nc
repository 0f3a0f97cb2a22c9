%
(corrected by trunnion: model 7d1b17416727, machine Middle-size trunnion, serial 0001)
G0X1.002Y1.9978Z3.0016A-40.0008C4.9999
G1X2.002F100
M30
%
