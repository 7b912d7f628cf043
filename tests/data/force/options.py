"""References for the options of version 3 of the force law and for the damping of version 5, made by other means than the law's own.

Writes relaxing.*, yielding.*, stiffening.*, breakaway.*, damping.* and toughness.csv beside this file. The branches are integrated by SciPy's DOP853 at a relative tolerance of
1e-12, tick by tick, from their differential equation q' = g k w' - q/tau; what they lose is the integral of q^2/(g k tau) on the way. Tents
that stiffen and friction that breaks away are closed forms of the displacement; toughness is a quadrature and a search.

    python options.py
"""

import json
from pathlib import Path

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import minimize_scalar

HERE = Path(__file__).parent
HEADER = "t_s,x_m,v_m_per_s,F_n,F_tip_n,F_rim_n,F_viscous_n,F_friction_n,F_cutting_n,depth_m,events"


def layer(name, thickness_m, stiffness, tip_n, rim_n, **options):
    numbers = {
        "name": name,
        "thickness_m": thickness_m,
        "stiffness_n_per_m": stiffness,
        "damping_n_s_per_m2": 0.0,
        "tip_rupture_n": tip_n,
        "rim_rupture_n": rim_n,
        "friction_n_per_m": 0.0,
        "cutting_n": 0.0,
    }
    numbers.update(options.pop("numbers", {}))
    return {**numbers, "options": options}


def case(name, note, layers, tip_to_rim_m, **more):
    head = {"name": name, "note": note, "units": "SI", "law": 3}
    return {**head, "tip_to_rim_m": tip_to_rim_m, "presliding_stiffness_n_per_m": 2000.0, **more, "layers": layers}


def path(legs, dt_s):
    """Samples (t, x) along legs of (seconds, from, to)."""
    samples, start = [(0.0, legs[0][1])], 0
    for seconds, from_m, to_m in legs:
        ticks = round(seconds / dt_s)
        for tick in range(1, ticks + 1):
            samples.append(((start + tick) * dt_s, from_m + (to_m - from_m) * (tick / ticks)))
        start += ticks
    return samples


class Tent:
    """One contactor at one boundary, its branches integrated numerically."""

    def __init__(self, scene, boundary, reach_m):
        self.layer, self.boundary = scene["layers"][boundary], boundary
        self.depth_m = sum(l["thickness_m"] for l in scene["layers"][:boundary])
        branches = self.layer["options"].get("branches", [])
        self.k = self.layer["stiffness_n_per_m"]
        self.kappa = self.layer["options"].get("stiffening_n_per_m2", 0.0)
        self.stiffness = np.array([b["share"] * self.k for b in branches])
        self.tau = np.array([b["time_s"] for b in branches])
        self.q = np.zeros(len(branches))
        self.lost_j = 0.0
        self.reach_m = reach_m

    def dent_m(self):
        return max(self.reach_m - self.depth_m, 0.0)

    def move(self, to_m, dt_s):
        from_m, self.reach_m = self.reach_m, to_m
        if len(self.q) == 0 or max(from_m, to_m) <= self.depth_m:
            return
        # Touched within the tick: the branches work from there on.
        share = min((to_m - max(from_m, self.depth_m)) / (to_m - from_m), 1.0) if from_m < self.depth_m else 1.0
        seconds = dt_s * share
        rate = (to_m - max(from_m, self.depth_m)) / seconds

        def derivative(_, y):
            q = y[:-1]
            return np.append(self.stiffness * rate - q / self.tau, np.sum(q * q / (self.stiffness * self.tau)) * 1e3)

        start = np.append(self.q, 0.0)
        solved = solve_ivp(derivative, (0.0, seconds), start, method="DOP853", rtol=1e-12, atol=1e-15)
        self.q = solved.y[:-1, -1]
        self.lost_j += solved.y[-1, -1] / 1e3
        assert self.spring_n() + self.q.sum() >= 0.0, "the reference stays where nothing is let go of"

    def spring_n(self):
        return self.k * self.dent_m() + self.kappa * self.dent_m() ** 2

    def force_n(self):
        return self.spring_n() + self.q.sum()

    def judged_n(self):
        """What is held against the threshold."""
        return self.spring_n() if self.layer["options"].get("gives_way_at") == "dent" else self.force_n()


def puncture(scene, samples):
    """Rows of a needle or trocar without friction, cutting and damping, and what its branches have lost by each."""
    layers, lag_m = scene["layers"], scene["tip_to_rim_m"]
    bounds_m = np.concatenate([[0.0], np.cumsum([l["thickness_m"] for l in layers])])
    tip, rim, lost_j, rows = Tent(scene, 0, samples[0][1]), None, 0.0, []
    tip_open = rim_open = 0
    before = None
    for t_s, x_m in samples:
        dt_s = t_s - before[0] if before else 0.0
        for tent, reach_m in ((tip, x_m), (rim, x_m - lag_m)):
            if tent is not None and before:
                tent.move(reach_m, dt_s)
        events = []
        while tip is not None and tip.dent_m() > 0 and tip.judged_n() >= tip.layer["tip_rupture_n"]:
            events.append(f"tip:{tip_open}")
            lost_j, tip_open = lost_j + tip.lost_j, tip_open + 1
            tip = Tent(scene, tip_open, x_m) if tip_open < len(layers) else None
        if rim is None and lag_m > 0 and rim_open < tip_open:
            rim = Tent(scene, rim_open, x_m - lag_m)
        while rim is not None and rim.dent_m() > 0 and rim.judged_n() >= rim.layer["rim_rupture_n"]:
            events.append(f"rim:{rim_open}")
            lost_j, rim_open = lost_j + rim.lost_j, rim_open + 1
            rim = Tent(scene, rim_open, x_m - lag_m) if rim_open < tip_open else None
        tip_n, rim_n = (tent.force_n() if tent is not None else 0.0 for tent in (tip, rim))
        v = (x_m - before[1]) / dt_s if before else 0.0
        stop_m = bounds_m[tip_open] if tip_open < len(layers) else np.inf
        depth_m = max(min(x_m, stop_m), 0.0)
        now_j = lost_j + sum(tent.lost_j for tent in (tip, rim) if tent is not None)
        rows.append([t_s, x_m, v, tip_n + rim_n, tip_n, rim_n, 0.0, 0.0, 0.0, depth_m, "+".join(events), now_j])
        before = (t_s, x_m)
    return rows


def write(scene, rows, with_loss=False):
    (HERE / f"{scene['name']}.json").write_text(json.dumps(scene, indent=1) + "\n")
    header = HEADER + (",lost_j" if with_loss else "")
    lines = [",".join(n if isinstance(n, str) else repr(float(n)) for n in row[: 12 if with_loss else 11]) for row in rows]
    (HERE / f"{scene['name']}.csv").write_text("\n".join([header, *lines]) + "\n")


def relaxing():
    skin = [{"share": 0.6, "time_s": 0.4}, {"share": 0.3, "time_s": 6.0}]
    muscle = [{"share": 0.5, "time_s": 0.05}, {"share": 0.4, "time_s": 1.5}, {"share": 0.2, "time_s": 40.0}]
    layers = [
        layer("skin", 0.0008, 331.0, 1.0, 1.3, branches=skin),
        layer("fat", 0.0084, 83.0, 0.5, 0.6),
        layer("muscle", 0.039, 497.0, 1.5, 1.9, branches=muscle),
    ]
    note = "in, held, a little back, on through the skin, held in the fat and at the muscle, through it; 250 Hz"
    scene = case("relaxing", note, layers, 0.002)
    legs = [
        (0.26, -0.0005103, 0.0012897), (4.0, 0.0012897, 0.0012897), (0.04, 0.0012897, 0.0011897), (1.0, 0.0011897, 0.0011897),
        (0.4, 0.0011897, 0.0048897), (1.0, 0.0048897, 0.0048897), (0.4, 0.0048897, 0.0099897), (3.0, 0.0099897, 0.0099897),
        (0.04, 0.0099897, 0.0098897), (0.4, 0.0098897, 0.0168897), (1.0, 0.0168897, 0.0168897),
    ]
    write(scene, puncture(scene, path(legs, 0.004)), with_loss=True)


def yielding():
    """The relaxing trocar whose skin and muscle give way at a dent: paces of 7, 1 and 18 mm/s and rests change no place of an opening."""
    skin = [{"share": 0.6, "time_s": 0.4}, {"share": 0.3, "time_s": 6.0}]
    muscle = [{"share": 0.5, "time_s": 0.05}, {"share": 0.4, "time_s": 1.5}]
    layers = [
        layer("skin", 0.0008, 331.0, 1.0, 1.3, branches=skin, gives_way_at="dent"),
        layer("fat", 0.0084, 83.0, 0.5, 0.6),
        layer("muscle", 0.039, 497.0, 1.5, 1.9, branches=muscle, gives_way_at="dent", stiffening_n_per_m2=9000.0),
    ]
    scene = case("yielding", "boundaries that give way at a dent, met at three paces; 250 Hz", layers, 0.002)
    legs = [(0.4, -0.0005103, 0.0022897), (1.0, 0.0022897, 0.0022897), (3.6, 0.0022897, 0.0058897), (0.6, 0.0058897, 0.0166897), (1.0, 0.0166897, 0.0166897)]
    write(scene, puncture(scene, path(legs, 0.004)), with_loss=True)


def stiffening():
    layers = [
        layer("skin", 0.0008, 100.0, 1.0, 1.3, stiffening_n_per_m2=60000.0),
        layer("fat", 0.0084, 83.0, 0.5, 0.6),
        layer("capsule", 0.02, 20.0, 1.62, 2.0, stiffening_n_per_m2=20000.0),
    ]
    scene = case("stiffening", "a trocar through tents that stiffen; 2 mm/s, 100 Hz", layers, 0.002)
    write(scene, puncture(scene, path([(12.5, -0.0007103, 0.0242897), (6.0, 0.0242897, 0.0122897)], 0.01)))


def breakaway():
    """One layer of friction c and c_s below a skin that opens at once: everything is a function of where the needle turned."""
    kinetic, static, slid_m, k = 60.0, 110.0, 0.0015, 2000.0
    numbers = {"friction_n_per_m": kinetic}
    scene = case(
        "breakaway", "in, a short and a long rest, on, out; 4 mm/s, 100 Hz",
        [layer("muscle", 0.1, 1000.0, 0.0, 0.0, numbers=numbers, static_friction_n_per_m=static)], 0.0,
        breakaway={"slid_m": slid_m, "rest_s": 0.7},
    )
    turns = [(5.0, -0.0010203, 0.0189797), (0.5, 0.0189797, 0.0189797), (1.0, 0.0189797, 0.0229797), (0.9, 0.0229797, 0.0229797),
             (2.0, 0.0229797, 0.0309797), (6.0, 0.0309797, 0.0069797)]
    samples = path(turns, 0.01)
    x, t = np.array([s[1] for s in samples]), np.array([s[0] for s in samples])
    length = np.maximum(x, 0.0)
    force = np.zeros(len(x))

    def phase(select, start_n, start_m, sign):
        """Stretched from start_n at start_m under the static cap, then slid by slid_m under it, then kinetic."""
        trial = start_n + k * (x[select] - start_m)
        cap = static * length[select]
        held = np.clip(trial, -cap, cap)
        slid = np.abs((x[select] - start_m) - (held - start_n) / k) * (np.abs(trial) > cap)
        kinetic_n = sign * kinetic * length[select]
        force[select] = np.where(slid < slid_m, held, kinetic_n)

    first_in = np.argmax(x > 0)
    before = x[first_in - 1]
    # The needle is at the skin between two samples; its spring is stretched from the sample before, whose cap was 0.
    phase((t <= 5.0 + 1e-9) & (x > 0), 0.0, before, 1.0)
    # Half a second of rest is less than it takes: friction stays kinetic.
    select = (t > 5.0 + 1e-9) & (t <= 6.5 + 1e-9)
    force[select] = kinetic * length[select]
    rest_n = kinetic * 0.0229797
    force[(t > 6.5 + 1e-9) & (t <= 7.4 + 1e-9)] = rest_n
    phase((t > 7.4 + 1e-9) & (t <= 9.4 + 1e-9), rest_n, 0.0229797, 1.0)
    # Out: back by slid_m while the spring turns about, so that the shaft holds anew.
    phase(t > 9.4 + 1e-9, kinetic * 0.0309797, 0.0309797, -1.0)

    rows = []
    for i, (t_s, x_m) in enumerate(samples):
        v = (x_m - samples[i - 1][1]) / (t_s - samples[i - 1][0]) if i else 0.0
        rows.append([t_s, x_m, v, force[i], 0.0, 0.0, 0.0, force[i], 0.0, length[i], "tip:0" if i == first_in else ""])
    write(scene, rows)


def toughness():
    """A sharp tip's least force: the energy of a round hole opened from A to R by quadrature, and its minimum over A by a search."""
    lines = ["radius_m,shear_modulus_pa,fracture_energy_j_per_m2,threshold_n"]

    def stretch_j_per_m(hole, radius, mu):
        grown = radius**2 - hole**2

        # Over ln(rho), from the hole's rim to where nothing is stretched any more.
        def density(log_rho):
            rho2 = np.exp(2 * log_rho)
            return 0.5 * mu * (rho2 / (rho2 + grown) + (rho2 + grown) / rho2 - 2.0) * 2 * np.pi * rho2

        low, high = np.log(hole), np.log(radius) + 24.0
        cuts = np.linspace(low, high, 25)
        return sum(quad(density, a, b, epsabs=0.0, epsrel=1e-12)[0] for a, b in zip(cuts, cuts[1:]))

    for radius in (0.25e-3, 0.635e-3, 1e-3, 2e-3):
        for mu in (3e3, 44e3, 110e3):
            for fracture in (164.0, 2500.0):

                def force(share):
                    return np.pi * share * radius * fracture + stretch_j_per_m(share * radius, radius, mu)

                found = minimize_scalar(force, bounds=(1e-6, 1.0), method="bounded", options={"xatol": 1e-10})
                lines.append(",".join(repr(float(n)) for n in (radius, mu, fracture, found.fun)))
    (HERE / "toughness.csv").write_text("\n".join(lines) + "\n")


def damping():
    """Two layers that open at once and only damp. The elongation e of the spring is integrated from e' = x' - e/tau, tick by tick, with
    B = sum of b l of the tick; where B grows the force B e/tau is kept, where it shrinks the elongation."""
    tau = 0.01
    layers = [
        layer("fat", 0.0084, 80.0, 0.0, 0.0, numbers={"damping_n_s_per_m2": 100.0}),
        layer("muscle", 0.03, 500.0, 0.0, 0.0, numbers={"damping_n_s_per_m2": 300.0}),
    ]
    note = "in at 20 mm/s, held, out at 40 mm/s, in again while it still pulls, trembling, and out of the body; 500 Hz"
    scene = case("damping", note, layers, 0.0, damping_time_s=tau)
    scene["law"] = 5
    legs = [(1.2, -0.0010203, 0.0229797), (0.1, 0.0229797, 0.0229797), (0.3, 0.0229797, 0.0109797), (0.2, 0.0109797, 0.0149797)]
    legs += [(0.02, 0.0149797, 0.0157797), (0.02, 0.0157797, 0.0149797)] * 10 + [(0.8, 0.0149797, -0.0010203)]
    e = lost_j = b = 0.0
    before, rows, tip_open = None, [], 0
    for t_s, x_m in path(legs, 0.002):
        events = []
        while tip_open < 2 and x_m > (0.0, 0.0084)[tip_open]:
            events.append(f"tip:{tip_open}")
            tip_open += 1
        depth_m = max(x_m, 0.0)
        now = 100.0 * min(depth_m, 0.0084) + 300.0 * max(depth_m - 0.0084, 0.0)
        kept = e if now <= b else e * b / now
        lost_j += (b * e * e - now * kept * kept) / (2.0 * tau)
        e, b = kept, now
        if before and b > 0.0:
            rate, seconds = (x_m - before[1]) / (t_s - before[0]), t_s - before[0]
            solved = solve_ivp(
                lambda _, y: [rate - y[0] / tau, (b / tau * y[0]) ** 2 / b * 1e3], (0.0, seconds), [e, 0.0], method="DOP853", rtol=1e-12, atol=1e-18
            )
            e, lost_j = solved.y[0, -1], lost_j + solved.y[1, -1] / 1e3
        e = e if b > 0.0 else 0.0
        v = (x_m - before[1]) / (t_s - before[0]) if before else 0.0
        q = b / tau * e
        rows.append([t_s, x_m, v, q, 0.0, 0.0, q, 0.0, 0.0, depth_m, "+".join(events), lost_j])
        before = (t_s, x_m)
    write(scene, rows, with_loss=True)


relaxing()
yielding()
stiffening()
breakaway()
damping()
toughness()
