#!/usr/bin/env python3
"""Settling of a uniform suspension of two sizes, from the published drag laws.

In a closed column the volume flux is zero and grains of every size are in equilibrium:

    (rho_p - rho_mix) V_k g = F_k(w_k),   rho_mix = phi rho + (1 - phi) rho_p,
    v_f = -sum_k c_k w_k,   v_k = v_f + w_k

with w_k the interstitial slip of size k, F_k the drag of "model A" (the pressure gradient acts on the
grain beside it) and phi the porosity of both. Grains are disks per metre of depth, whose drag is that of
a sphere's coefficient over the frontal area 2 r. Prints `ratio,law,mean_fall_speed` (m/s), the mean over
equally many grains of both sizes, and writes the grains of each ratio as bidisperse_RATIO.csv.

    python3 tests/reference/bidisperse_settling.py
"""
import math

RHO, MU, RHO_P, G, R, SOLID = 1000.0, 1e-3, 2500.0, 9.81, 50e-6, 0.2
LAYERS = 400


def bare(re):  # Dallavalle 1943
    return (0.63 + 4.8 / math.sqrt(re)) ** 2


def schiller_naumann(re):
    return 24 / re * (1 + 0.15 * re**0.687) if re < 1000 else 0.44


def area_force(cd, w, r):
    return 0.5 * RHO * cd * 2 * r * w * w


def paper(w, r, phi, _):
    return phi**-1.8 * area_force(bare(phi * RHO * 2 * r * w / MU), w, r)


def di_felice(w, r, phi, _):
    re = phi * RHO * 2 * r * w / MU
    chi = 3.7 - 0.65 * math.exp(-((1.5 - math.log10(re)) ** 2) / 2)
    # Di Felice: F = 1/2 rho Cd A (phi w)^2 phi^-chi
    return area_force(bare(re), phi * w, r) * phi**-chi


def migflow(w, r, phi, _):
    re = RHO * phi * 2 * r * w / MU
    exponent = 2.8 - 0.65 * math.exp(-((1.5 - math.log(re)) ** 2) / 2)
    return phi * phi**-exponent * area_force(bare(re), w, r)


def wen_yu(w, r, phi, _):
    return phi**-1.65 * area_force(schiller_naumann(phi * RHO * 2 * r * w / MU), w, r)


def gidaspow(w, r, phi, _):
    d, c = 2 * r, 1 - phi
    ergun = math.pi * r * r * (150 * c * MU / (phi * d * d) + 1.75 * RHO * w / d) * w
    share = min(max((phi - 0.78) / 0.04, 0), 1)  # blended, as it is discontinuous as published
    return share * wen_yu(w, r, phi, None) + (1 - share) * ergun


def beetstra(w, r, phi, sauter):
    c, re, y = 1 - phi, RHO * phi * sauter * w / MU, 2 * r / sauter
    f = 10 * c / phi**2 + phi**2 * (1 + 1.5 * math.sqrt(c))
    f += (0.413 * re / (24 * phi**2)) * (1 / phi + 3 * phi * c + 8.4 * re**-0.343) / (
        1 + 10 ** (3 * c) * re ** (-(1 + 4 * c) / 2)
    )
    # without 0.064 phi y^3, which belongs to the equations without a pressure force on the grain
    return 12 * MU * phi * w * f * (phi * y + c * y * y)


def stokes(w, r, phi, _):
    return 12 * MU * w


LAWS = {
    "dallavalle": paper,
    "stokes": stokes,
    "di-felice": di_felice,
    "wen-yu": wen_yu,
    "gidaspow": gidaspow,
    "beetstra": beetstra,
    "migflow": migflow,
}


def slip(force, weight):
    low, high = 1e-12, 1.0
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if force(middle) < weight else (low, middle)
    return low


def main():
    for ratio in (1.0, 1.5, 2.0):
        radii = (R, ratio * R)
        cell = math.sqrt(math.pi * sum(r * r for r in radii) / SOLID)
        sauter = 2 * sum(r**3 for r in radii) / sum(r**2 for r in radii)
        phi = 1 - SOLID
        mixture = phi * RHO + SOLID * RHO_P
        print(f"# ratio {ratio}: cell {cell:.9e} m, column {LAYERS * cell:.9e} m")
        for name, law in LAWS.items():
            slips = []
            for r in radii:
                weight = (RHO_P - mixture) * math.pi * r * r * G
                slips.append(slip(lambda w: law(w, r, phi, sauter), weight))
            flux = sum(math.pi * r * r / cell**2 * w for r, w in zip(radii, slips))
            print(f"{ratio},{name},{sum(slips) / 2 - flux:.9e}")
        with open(f"{__file__.rsplit('/', 1)[0]}/bidisperse_{ratio}.csv", "w") as out:
            out.write("x,y,radius\n")
            for layer in range(LAYERS):
                for column, r in zip((0.25, 0.75), radii):
                    out.write(f"{column * cell:.9e},{(layer + 0.5) * cell:.9e},{r:.9e}\n")


if __name__ == "__main__":
    main()
