// A channel of 2 x 1 with a disk in it.
h = 0.35;
Point(1) = {0, 0, 0, h}; Point(2) = {2, 0, 0, h}; Point(3) = {2, 1, 0, h}; Point(4) = {0, 1, 0, h};
Point(5) = {0.7, 0.5, 0, h}; Point(6) = {0.9, 0.5, 0, h}; Point(7) = {0.5, 0.5, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Circle(5) = {6, 5, 7}; Circle(6) = {7, 5, 6};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {5, 6};
Plane Surface(1) = {1, 2};
Physical Curve("inlet", 1) = {4}; Physical Curve("outlet", 2) = {2};
Physical Curve("walls", 3) = {1, 3}; Physical Curve("the disk", 4) = {5, 6};
Physical Surface("fluid", 5) = {1};
