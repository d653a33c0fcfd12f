"""The fluid by finite elements of scikit-fem: P2 velocity, P1 pressure (Taylor–Hood).

Unknowns: interstitial velocity v and pressure p. With w, q their test functions, and for any P2 field the
averages at the nodes of the mesh that grains feel,

    v_α = ∫N_α v / ℓ_α,   G_α = ∫N_α ∇p / ℓ_α,   ℓ_α = ∫N_α                                       (F1)

    ∫ρφ ((v − vⁿ)/Δt + vⁿ·∇v)·w + ∫2μφ D(v):D(w) + ∫φ∇p·w − ∫ρφ g·w
                          + Σ_α ℓ_α w_α·(β_α v_α + c_α G_α − s_α) = 0                              (F2)
    ∫∇q·(φ v + j⁰ − κ∇p) + Σ_α c_α v_α·∫N_α ∇q = ∮ q u_in·n                                        (F3)

The grains act on the averages that they sample: action is reaction to round-off, the drag does positive
work, and c is symmetric between (F2) and (F3). Backward Euler, one linear solve a step.
"""

import sys

try:
    import numpy as np
    import scipy.sparse as sparse
    import sillage
    import skfem
    from scipy.sparse.linalg import splu
    from skfem.helpers import grad
except ImportError as missing:
    print(f"error: {missing}: run engines/set-up skfem-fluid", file=sys.stderr)
    sys.exit(4)

from ordering import nested_dissection
from rectangle import rectangle
from sizes import counter_clockwise, refined

QUADRATURE = 5


class SkfemFluid(sillage.FluidEngine):
    name, version = "skfem-fluid", f"scikit-fem {skfem.__version__}"
    capabilities = ("affine-response", "checkpoint", "adapts")

    def configure(self, scene):
        refuse_what_is_missing(scene)
        self.scene = scene
        self.gravity = np.array(scene["gravity"])
        mesh = self.solve_on(scene.get("refinement"))
        self.accepted = np.repeat(np.array(scene["initial_velocity"])[:, None], self.velocity.N, axis=1)
        return mesh

    def adapt(self, sizes):
        before, accepted = self.velocity, self.accepted
        mesh = self.solve_on(sizes)
        at = before.probes(self.velocity.doflocs)
        self.accepted = np.array([at @ component for component in accepted])
        return mesh

    def solve_on(self, sizes):
        """Take a mesh with triangles of these sizes, or the rectangle as it is."""
        self.nodes, self.triangles = rectangle(self.scene["mesh"]["rectangle"])
        mesh = skfem.MeshTri(self.nodes.T, self.triangles.T)
        if sizes is not None:
            mesh = refined(mesh, sizes)
            self.nodes, self.triangles = counter_clockwise(mesh)
        self.velocity = skfem.Basis(mesh, skfem.ElementTriP2(), intorder=QUADRATURE)
        self.pressure = self.velocity.with_element(skfem.ElementTriP1())
        self.constant_matrices()
        self.boundary_conditions(mesh)
        # Before the first porosity is known: as if there were no grains.
        self.order_unknowns()
        self.candidate = None
        print(f"{self.velocity.N} velocity and {self.pressure.N} pressure nodes", flush=True)
        return sillage.Mesh(self.nodes, self.triangles, nodal_mass=self.mass)

    def constant_matrices(self):
        test = skfem.BilinearForm(lambda p, q, _: p * q)
        self.average = test.assemble(self.velocity, self.pressure).tocsr()  # ∫N_α ψ_j
        self.gradient = [
            skfem.BilinearForm(lambda p, q, _, d=d: q * p.grad[d]).assemble(self.pressure, self.pressure).tocsr()
            for d in range(2)
        ]  # ∫N_α ∂_d N_j
        self.mass = skfem.LinearForm(lambda q, _: 1.0 * q).assemble(self.pressure)

    def boundary_conditions(self, mesh):
        """Which values are given: velocity (later times 1/φ), pressure; and ∮ q u_in·n."""
        rectangle = self.scene["mesh"]["rectangle"]
        (left, bottom), (right, top) = rectangle["lower"], rectangle["upper"]
        small = 1e-9 * max(right - left, top - bottom)
        sides = {
            "left": (0, left),
            "right": (0, right),
            "bottom": (1, bottom),
            "top": (1, top),
        }
        place = self.velocity.doflocs
        self.given = np.zeros((2, self.velocity.N), bool)
        self.superficial = np.zeros((2, self.velocity.N))
        self.inflow = np.zeros(self.pressure.N)
        self.open = np.zeros(self.pressure.N, bool)
        self.open_pressure = np.zeros(self.pressure.N)
        # A wall wins at a corner, whatever the order of the names.
        order = ["open", "slip", "inflow", "no-slip"]
        conditions = self.scene["boundaries"].items()
        for name, condition in sorted(conditions, key=lambda item: order.index(kind_of(item[1]))):
            axis, at = sides[name]
            kind, on_side = kind_of(condition), abs(place[axis] - at) < small
            if kind == "open":
                nodes = abs(self.nodes[:, axis] - at) < small
                highest = self.nodes[nodes] @ -self.gravity
                highest = self.nodes[nodes][highest.argmax()]
                self.open |= nodes
                hydrostatic = self.scene["density"] * (self.nodes[nodes] - highest) @ self.gravity
                self.open_pressure[nodes] = condition["open"]["pressure"] + hydrostatic
            elif kind == "slip":
                self.given[axis, on_side] = True
                self.superficial[axis, on_side] = 0.0
            elif kind == "no-slip":
                self.given[:, on_side] = True
                self.superficial[:, on_side] = 0.0
            else:
                along = place[1 - axis, on_side]
                half = 0.5 * (along.max() - along.min())
                offset = (along - along.min() - half) / half
                parabolic = condition["inflow"]["profile"] == "parabolic"
                shape = 1.0 - offset**2 if parabolic else np.ones_like(along)
                self.given[:, on_side] = True
                self.superficial[:, on_side] = np.outer(condition["inflow"]["velocity"], shape)
                self.inflow += self.flux_through(mesh, axis, at, small)
        self.outlets = self.outlet_blocks(mesh, sides, small)
        if not self.open.any():
            # Pressure is known up to a constant.
            self.open[-1] = True

    def outlet_blocks(self, mesh, sides, small):
        """Facets where flow leaves: the viscous traction there is that of 2D(v) less its transpose, so
        that a developed flow stays as it is."""
        open_sides = [sides[name] for name, kind in self.scene["boundaries"].items() if kind_of(kind) == "open"]
        if not open_sides:
            return None
        on_open = lambda x: np.any([abs(x[axis] - at) < small for axis, at in open_sides], axis=0)
        facets = mesh.facets_satisfying(on_open, boundaries_only=True)
        velocity = skfem.FacetBasis(mesh, skfem.ElementTriP2(), facets=facets, intorder=QUADRATURE)
        return velocity, velocity.with_element(skfem.ElementTriP1())

    def order_unknowns(self):
        """Numbers of the unknowns, in the order of elimination."""
        link = abs(self.average) > 0.0
        averaged = (link.T @ link).astype(float)
        pressure = (link.T @ (abs(self.gradient[0]) + abs(self.gradient[1]) + sparse.identity(self.pressure.N)) > 0.0)
        nodes = (abs(self.gradient[0]) + abs(self.gradient[1]) + sparse.identity(self.pressure.N) > 0.0)
        pattern = sparse.bmat(
            [[averaged, averaged, pressure], [averaged, averaged, pressure], [pressure.T, pressure.T, nodes]],
            format="csr",
            dtype=float,
        )
        given = np.concatenate([*self.given, self.open])
        free = np.flatnonzero(~given)
        place = np.concatenate([self.velocity.doflocs.T, self.velocity.doflocs.T, self.nodes])[free]
        is_pressure = free >= 2 * self.velocity.N
        self.unknown = free[nested_dissection(pattern[free][:, free], place, is_pressure)]

    def flux_through(self, mesh, axis, at, small):
        """∮ q u_in·n over one side."""
        facets = mesh.facets_satisfying(lambda x: abs(x[axis] - at) < small, boundaries_only=True)
        velocity = skfem.FacetBasis(mesh, skfem.ElementTriP2(), facets=facets, intorder=QUADRATURE)
        pressure = skfem.FacetBasis(mesh, skfem.ElementTriP1(), facets=facets, intorder=QUADRATURE)
        normal = [velocity.interpolate(self.superficial[d]) * pressure.normals[d] for d in range(2)]
        return skfem.LinearForm(lambda q, w: q * w.flux).assemble(pressure, flux=normal[0] + normal[1])

    def advance(self, request, inputs, outputs):
        porosity = inputs.porosity.copy()
        matrix, right = self.assemble(request.dt, porosity, inputs)
        solution = self.solve(matrix, right, porosity)
        count = self.velocity.N
        velocity, pressure = solution[: 2 * count].reshape(2, count), solution[2 * count :]
        average = (self.average @ velocity.T) / self.mass[:, None]
        gradient = np.column_stack([g @ pressure / self.mass for g in self.gradient])
        outputs.interstitial_velocity[:] = average  # (F1)
        outputs.pressure_gradient[:] = gradient
        outputs.pressure[:] = pressure
        self.candidate = velocity
        return self.report(porosity, inputs, velocity, pressure, average, gradient)

    def assemble(self, dt, porosity, inputs):
        density, viscosity = self.scene["density"], self.scene["dynamic_viscosity"]
        nodal = {name: self.pressure.interpolate(value) for name, value in {
            "phi": porosity, "kappa": inputs.solid_mobility.copy()}.items()}
        old = [self.velocity.interpolate(component) for component in self.accepted]
        convection = 1.0 if self.scene["convection"] else 0.0

        def momentum(v, w, f):
            carried = convection * (f.ax * v.grad[0] + f.ay * v.grad[1])
            diffusion = v.grad[0] * w.grad[0] + v.grad[1] * w.grad[1]
            return density * f.phi * (v / dt + carried) * w + viscosity * f.phi * diffusion

        def crossed(k, l):
            return lambda v, w, f: viscosity * f.phi * v.grad[k] * w.grad[l]

        def of(form, trial, test, **fields):
            return skfem.BilinearForm(form).assemble(trial, test, **fields).tocsr()

        basis, phi = self.velocity, nodal["phi"]
        same = of(momentum, basis, basis, phi=phi, ax=old[0], ay=old[1])
        grains = self.average.T @ sparse.diags(inputs.drag / self.mass) @ self.average
        # ∂_d v_c ∂_c w_d: row d, column c
        blocks = [[of(crossed(d, c), basis, basis, phi=phi) for c in range(2)] for d in range(2)]
        if self.outlets:
            velocity, nodes = self.outlets
            for d in range(2):
                for c in range(2):
                    # ∮ μφ n_c ∂_d v_c w_d
                    form = lambda v, w, f, c=c, d=d: viscosity * f.phi * w * v.grad[d] * velocity.normals[c]
                    blocks[d][c] = blocks[d][c] - of(form, velocity, velocity, phi=nodes.interpolate(porosity))
        pressure = []
        for d in range(2):
            whole = of(lambda p, w, f, d=d: f.phi * p.grad[d] * w, self.pressure, basis, phi=phi)
            entrained = self.average.T @ sparse.diags(inputs.entrained_fraction / self.mass) @ self.gradient[d]
            pressure.append(whole + entrained)
        mobility = of(
            lambda p, q, f: f.kappa * (p.grad[0] * q.grad[0] + p.grad[1] * q.grad[1]),
            self.pressure, self.pressure, kappa=nodal["kappa"],
        )
        matrix = sparse.bmat(
            [
                [same + grains + blocks[0][0], blocks[0][1], pressure[0]],
                [blocks[1][0], same + grains + blocks[1][1], pressure[1]],
                [pressure[0].T, pressure[1].T, -mobility],
            ],
            format="csc",
        )
        load = skfem.LinearForm(lambda w, f: density * f.phi * f.a * w)
        right = [
            load.assemble(basis, phi=phi, a=old[d] / dt + self.gravity[d])
            + self.average.T @ inputs.drag_source[:, d]
            for d in range(2)
        ]
        flux = -sum(self.gradient[d].T @ inputs.solid_flux[:, d] for d in range(2))
        return matrix, np.concatenate([*right, flux + self.inflow])

    def solve(self, matrix, right, porosity):
        """The given values go to the right-hand side."""
        local = porosity_at(self.velocity, self.pressure, porosity)
        values = np.concatenate([*(self.superficial / local), self.open_pressure])
        values[self.unknown] = 0.0
        free = self.unknown
        right = (right - matrix @ values)[free]
        inner = matrix[free][:, free]
        # Momentum and continuity differ by orders of magnitude: equal diagonals keep pivots honest.
        size = np.sqrt(abs(inner).max(axis=1).toarray().ravel())
        scale = sparse.diags(1.0 / size)
        try:
            factor = splu(
                (scale @ inner @ scale).tocsc(),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise sillage.NotFinite(f"the matrix of the fluid is singular: {error}") from None
        values[free] = (scale @ factor.solve(scale @ right))
        if not np.isfinite(values).all():
            raise sillage.NotFinite("the solution of the fluid is not finite")
        return values

    def report(self, porosity, inputs, velocity, pressure, average, gradient):
        phi = self.pressure.interpolate(porosity)
        energy = skfem.Functional(lambda f: 0.5 * self.scene["density"] * f.phi * (f.vx**2 + f.vy**2))
        vx, vy = (self.velocity.interpolate(component) for component in velocity)
        slope = self.pressure.interpolate(pressure)
        flow = skfem.Functional(lambda f: f.kappa * (f.p.grad[0] ** 2 + f.p.grad[1] ** 2))
        mobility = self.pressure.interpolate(inputs.solid_mobility.copy())
        # What the grains do to the fluid in (F2) and (F3).
        pull = inputs.drag_source - inputs.drag[:, None] * average
        work = self.mass @ (average * pull + inputs.solid_flux * gradient).sum(axis=1)
        return sillage.FluidReport(
            solid_power=work - flow.assemble(self.velocity, kappa=mobility, p=slope),
            diagnostics={"kinetic_energy": energy.assemble(self.velocity, phi=phi, vx=vx, vy=vy)},
        )

    def commit(self):
        self.accepted, self.candidate = self.candidate, None

    def save(self, path):
        with open(path, "wb") as file:
            np.savez(file, velocity=self.accepted)

    def restore(self, path):
        with np.load(path, allow_pickle=False) as stored:
            if stored["velocity"].shape != self.accepted.shape:
                raise sillage.SceneError(f"{path} holds the state of another mesh")
            self.accepted, self.candidate = stored["velocity"], None


def kind_of(condition):
    return condition if isinstance(condition, str) else next(iter(condition))


def porosity_at(velocity, pressure, porosity):
    """P1 values at the P2 nodes."""
    local = np.empty(velocity.N)
    local[velocity.nodal_dofs[0]] = porosity[pressure.nodal_dofs[0]]
    ends = velocity.mesh.facets
    local[velocity.facet_dofs[0]] = 0.5 * (porosity[ends[0]] + porosity[ends[1]])
    return local


def refuse_what_is_missing(scene):
    """Say what this engine cannot do, with the key of the scene."""
    if scene["dimension"] != 2:
        raise sillage.SceneError(
            f"skfem-fluid is for two dimensions, the scene has {scene['dimension']}: take sillage-fluid"
        )
    if "rectangle" not in scene["mesh"]:
        raise sillage.SceneError("fluid.domain.mesh: skfem-fluid has rectangles only, use fluid.domain.rectangle")
    wanted = {"time_scheme": "backward-euler", "nonlinear": "picard", "viscous_form": "symmetric"}
    for key, value in wanted.items():
        if scene[key] != value:
            raise sillage.SceneError(f"fluid.{key} is {scene[key]!r}: skfem-fluid has {value!r} only")
    for name, condition in scene["boundaries"].items():
        if kind_of(condition) == "periodic":
            raise sillage.SceneError(f"fluid.boundaries.{name} is periodic: skfem-fluid has no periodic domains")


if __name__ == "__main__":
    sys.exit(sillage.run_fluid(SkfemFluid()))
