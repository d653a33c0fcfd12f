// A rectangle of 4 x 3 quadrilaterals, its surface turned over (clockwise).
Point(1) = {0, 0, 0}; Point(2) = {4, 0, 0}; Point(3) = {4, 3, 0}; Point(4) = {0, 3, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {-1, -4, -3, -2};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 5; Transfinite Curve {2, 4} = 4;
Transfinite Surface {1}; Recombine Surface {1};
Physical Curve("floor", 7) = {1}; Physical Curve(12) = {2, 3, 4};
Physical Surface("fluid", 1) = {1};
