%
(corrected by trunnion: model 1, machine x, serial 2)
G0 X1
M2
%
