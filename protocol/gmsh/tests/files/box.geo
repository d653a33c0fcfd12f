// A box of 1 x 2 x 3 with names on its floor, lid and sides.
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 1, 2};
Transfinite Curve {1, 3} = 3;
Transfinite Curve {2, 4} = 4;
Transfinite Surface {1};
