"""Grains moved by scontact, the contact dynamics of MigFlow (`migflow` from PyPI).

scontact solves, per sub-step δ, for bodies of inverse mass w under forces F

    v = vⁿ + w δ F + contact impulses,   gap + δ u_n ≥ 0,   |R_t| ≤ μ R_n

The drag −γ v is implicit when it gets the mass and the force

    1/w = m + γδ,   F = m g + q − γ vⁿ                                                   (S1)

since then vⁿ + wδF = (m vⁿ + δ(m g + q))/(m + γδ), and contacts meet the mass m + γδ.
"""

import sys

try:
    import numpy as np
    import scipy.sparse
    import sillage
    from scipy.spatial import cKDTree
    from migflow import scontact
except (ImportError, OSError) as missing:
    print(f"error: {missing}: run engines/set-up scontact-particles", file=sys.stderr)
    sys.exit(4)

PARTICLE_SEGMENT = 1  # contact_type; 0 is of two grains
#: Part of the smallest radius that two grains may come closer in a sub-step.
APPROACH = 0.5
#: Radii a grain may move in a sub-step: contacts are looked for that far.
TRAVEL = 4.0


class Scontact(sillage.ParticleEngine):
    name, version = "scontact-particles", "migflow 1.4"
    capabilities = ("implicit-drag", "contact-state", "checkpoint")

    def configure(self, scene, grains):
        if scene["dimension"] != 2:
            raise sillage.SceneError(
                f"{self.name} is for two dimensions, the scene has {scene['dimension']}: "
                "take sillage-particles, rapier-particles or lammps-particles"
            )
        if any(scene["period"]):
            raise sillage.SceneError(
                f"the domain is periodic ({scene['period']} m): scontact-particles has walls only"
            )
        self.scene, self.grains = scene, grains
        self.gravity = np.array(scene["gravity"])
        self.movable = ~grains.fixed
        self.problem = self.build(scene, grains)
        self.problem.body_velocity()[: len(grains)] = grains.velocity * self.movable[:, None]
        grains.velocity = grains.velocity * self.movable[:, None]
        self.inverse_inertia = self.problem.body_invert_inertia().copy()
        self.accepted = self.state()
        self.candidate = None
        return grains

    @staticmethod
    def build(scene, grains):
        problem = scontact.ParticleProblem(2)
        # The library looks through all bodies for each new one.
        problem._body_uid_max = lambda: problem.n_bodies() - 1
        for x, r, m, fixed in zip(grains.position, grains.radius, grains.mass, grains.fixed):
            inertia = scene["inertia_factor"] * m * r**2
            problem.add_particle(x, r, m, "grain", fixed, 1.0 / inertia)
        for wall in scene["walls"]:
            a, b = (np.array(corner) for corner in wall["corners"])
            problem.add_boundary_segment(a, b, "wall", "wall")
        problem.get_material_id("wall")
        problem.set_friction_coefficient(scene["friction"], "grain", "grain")
        problem.set_friction_coefficient(scene["wall_friction"], "grain", "wall")
        return problem

    def state(self):
        """Everything that the next iteration depends on."""
        p = self.problem
        arrays = (p.body_position(), p.body_velocity(), p.body_omega(), p.body_theta(), p.contacts())
        return [array.copy() for array in arrays]

    def set_state(self, state):
        p = self.problem
        p.body_position()[:], p.body_velocity()[:], p.body_omega()[:], p.body_theta()[:] = state[:4]
        p._array_set("contacts", state[4])

    def advance(self, request, inputs, outputs):
        count = len(self.grains)
        drag, force = inputs.grain_drag.copy(), inputs.grain_force.copy()
        start = self.accepted[0][:count]
        sub_steps = max(request.sub_steps, 1)
        while True:
            self.set_state(self.accepted)
            if request.sub_steps == 0:
                sub_steps = max(sub_steps, self.sub_steps_needed(request, drag, force))
            if sub_steps > self.scene["sub_steps_max"]:
                raise sillage.NotConverged(
                    f"{sub_steps} sub-steps are needed, sub_steps_max is {self.scene['sub_steps_max']}"
                )
            contacts = self.move(request, sub_steps, drag, force)
            if contacts is not None:
                break
            sub_steps *= 2
        self.candidate = self.state()
        position, velocity = self.candidate[0][:count], self.candidate[1][:count]
        outputs.grain_position[:] = position
        outputs.grain_velocity[:] = velocity
        outputs.grain_mean_velocity[:] = (position - start) / request.dt
        outputs.grain_contact[:] = self.contact_state(contacts)
        energy = 0.5 * (self.grains.mass[:, None] * velocity**2)[self.movable].sum()
        numbers = {"penetration_max": self.penetration(), "kinetic_energy": energy}
        return sillage.ParticleReport(sub_steps, touching=len(contacts[-1]), diagnostics=numbers)

    def sub_steps_needed(self, request, drag, force):
        """From how fast grains come together, and how far contacts are looked for."""
        mass, dt = self.grains.mass, request.dt
        velocity = self.accepted[1][: len(mass)]
        pull = mass[:, None] * self.gravity + force
        free = (mass[:, None] * velocity + dt * pull) / (mass + dt * drag)[:, None]
        free = np.where(self.movable[:, None], free, 0.0)
        speed = np.linalg.norm(free, axis=1).max(initial=0.0)
        spread = np.linalg.norm(free - np.median(free, axis=0), axis=1).max(initial=0.0)
        radius = self.grains.radius.min(initial=np.inf)
        needed = max(2.0 * spread * dt / (APPROACH * radius), speed * dt / (TRAVEL * radius), 1.0)
        if not np.isfinite(needed):
            raise sillage.NotFinite("a force or a drag coefficient leads to velocities that are not finite")
        return int(np.ceil(needed))

    def move(self, request, sub_steps, drag, force):
        """All sub-steps; the active contacts of each, or None where scontact did not converge."""
        p, count = self.problem, len(self.grains)
        delta = request.dt / sub_steps
        mass = self.grains.mass
        weight = mass[:, None] * self.gravity + force
        inverse = np.where(self.movable, 1.0 / (mass + delta * drag), 0.0)
        p.body_invert_mass()[:count] = inverse[:, None]
        # scontact stops when a visit moves a contact by less than a length.
        gravity = np.linalg.norm(self.gravity)
        tolerance = max(request.tolerance * gravity * request.dt * delta, 1e-9 * self.grains.radius.min())
        contacts = []
        for _ in range(sub_steps):
            before = p.body_velocity()[:count]
            travel = np.linalg.norm(before, axis=1).max(initial=0.0) + gravity * delta
            p.contact_detection_d = max(self.grains.radius.max(), 3.0 * travel * delta)
            if not p.iterate(delta, weight - drag[:, None] * before, tol=tolerance):  # (S1)
                return None
            if not np.isfinite(p.body_position()).all():
                raise sillage.NotFinite("scontact moved a grain to a place that is not finite")
            contacts.append(self.active())
        return contacts

    def active(self):
        """Rows (first body, second body, is a wall) of contacts that carry a force."""
        contacts = self.problem.contacts()
        contacts = contacts[(contacts["reaction"] != 0.0).any(axis=1)]
        wall = contacts["contact_type"] == PARTICLE_SEGMENT
        return np.column_stack([contacts["o"].astype(np.int64), wall])

    def contact_state(self, contacts):
        """0 free, 1 touches, 2 connected to a wall or a fixed grain, over all sub-steps."""
        count = len(self.grains)
        rows = np.concatenate([*contacts, np.empty((0, 3), np.int64)])
        wall = rows[:, 2] == 1
        # A wall is written first; every wall, and every fixed grain, is the ground.
        first = np.where(wall, count, rows[:, 0])
        second = rows[:, 1]
        touches = np.zeros(count + 1, bool)
        touches[first] = touches[second] = True
        fixed = np.append(self.grains.fixed, True)
        first, second = (np.where(fixed[side], count, side) for side in (first, second))
        graph = scipy.sparse.coo_array((np.ones(len(rows)), (first, second)), (count + 1, count + 1))
        label = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
        state = touches[:count] * np.where(label[:count] == label[count], 2, 1)
        return np.where(self.grains.fixed, 2, state)

    def penetration(self):
        """Deepest overlap of two grains, of the smaller radius."""
        position, radius = self.candidate[0], self.grains.radius
        pairs = cKDTree(position[: len(radius)]).query_pairs(2.0 * radius.max(), output_type="ndarray")
        if len(pairs) == 0:
            return 0.0
        i, j = pairs.T
        apart = np.linalg.norm(position[i] - position[j], axis=1)
        depth = (radius[i] + radius[j] - apart) / np.minimum(radius[i], radius[j])
        return max(float(depth.max()), 0.0)

    def commit(self):
        self.accepted, self.candidate = self.candidate, None

    def save(self, path):
        with open(path, "wb") as file:
            np.savez(file, *self.accepted, radius=self.grains.radius, mass=self.grains.mass)

    def restore(self, path):
        with np.load(path, allow_pickle=False) as stored:
            for name, own in (("radius", self.grains.radius), ("mass", self.grains.mass)):
                if not np.array_equal(stored[name], own):
                    raise sillage.SceneError(f"{path} holds the state of other grains: {name} differs")
            self.accepted, self.candidate = [stored[f"arr_{k}"] for k in range(5)], None


if __name__ == "__main__":
    sys.exit(sillage.run_particles(Scontact()))
