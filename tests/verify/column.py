"""A steering column with play, integrated by fixed steps of Runge and Kutta: METHOD 19, own text.

Nothing of it is `cardan`'s: numbers of METHOD's check, a step of half a millisecond, the instant of
every touch and every parting by halving.
"""

from math import atan2, cos, degrees, pi, radians, sin

KINGPIN, C, KT, SPIN, R, TRAIL, CORNERING, RELAXES = 15.0, 20.0, 30e3, 14.0, 0.45, 0.03, 80e3, 0.8
ROLL, ROLL_C, ROLL_K, GEAR, GEAR_C, HAND, HAND_C = 120.0, 1500.0, 300e3, 5.0, 100.0, 12.0, 300.0
COLUMN, RATIO, ARM, HERTZ, V = 15e3, 18.0, 0.02, 2e9, 15.0


class Column:
    def __init__(self, *, play=0.5, restitution=0.7, beta=0.0, pin=0.0):
        self.g0, self.pin, self.slant = radians(play), radians(pin), cos(radians(beta))
        self.a = 8 * (1 - restitution) / (5 * restitution)  # Flores and others

    def gap(self, z):
        """How far the column is twisted, how fast, and the joint's gear."""
        out = [atan2(sin(u), cos(u) * self.slant) for u in (RATIO * z[4] + self.pin, self.pin)]
        turned = (out[0] - out[1] + pi) % (2 * pi) - pi
        u = RATIO * z[4] + self.pin
        gear = self.slant / (self.slant**2 * cos(u) ** 2 + sin(u) ** 2)
        return turned - RATIO * z[3], RATIO * (gear * z[9] - z[8]), gear

    def torque(self, z, side, touched):
        gap, rate, gear = self.gap(z)
        deep = side * gap - self.g0
        if not side or deep <= 0:
            return 0.0, gear
        k = COLUMN / RATIO**2
        q = min(deep * k, 2 * ARM * HERTZ * (deep * ARM) ** 1.5)
        for _ in range(60):
            left = q / k + (q / (2 * ARM * HERTZ)) ** (2 / 3) / ARM - deep
            slope = 1 / k + 2 / 3 * (2 * ARM * HERTZ) ** (-2 / 3) * q ** (-1 / 3) / ARM
            better = max(q - left / slope, q / 2)
            if abs(better - q) < 1e-13 * q:
                break
            q = better
        return side * q * max(0.0, 1 + self.a * side * rate / touched), gear

    def rates(self, z, side, touched):
        left, right, roll, s, _, dl, dr, droll, ds, dh, fl, fr = z
        q, gear = self.torque(z, side, touched)
        spin = SPIN * V / R
        return [
            dl, dr, droll, ds, dh,
            (-C * dl - KT * (left - s) - spin * droll - TRAIL * fl) / KINGPIN,
            (-C * dr - KT * (right - s) - spin * droll - TRAIL * fr) / KINGPIN,
            (-ROLL_C * droll - ROLL_K * roll + spin * (dl + dr) - R * (fl + fr)) / ROLL,
            (-GEAR_C * ds - KT * (2 * s - left - right) + RATIO * q) / GEAR,
            (-HAND_C * dh - RATIO * gear * q) / HAND,
            (CORNERING * (left + (TRAIL * dl + R * droll) / V) - fl) * V / RELAXES,
            (CORNERING * (right + (TRAIL * dr + R * droll) / V) - fr) * V / RELAXES,
        ]  # fmt: skip

    def step(self, z, h, *how):
        def ahead(by, slope):
            return [x + by * y for x, y in zip(z, slope, strict=True)]

        a = self.rates(z, *how)
        b = self.rates(ahead(h / 2, a), *how)
        c = self.rates(ahead(h / 2, b), *how)
        d = self.rates(ahead(h, c), *how)
        total = [p + 2 * q + 2 * r + s for p, q, r, s in zip(a, b, c, d, strict=True)]
        return ahead(h / 6, total)

    def run(self, duration, *, kick=1e-3, h=5e-4):
        """Times, the left wheel in deg, and the times and speeds of touches."""
        z, t, side, touched = [kick, *[0.0] * 11], 0.0, 0, 1.0
        times, wheel, at, speeds = [], [], [], []

        def left(z):
            gap = self.gap(z)[0]
            return side * gap < self.g0 if side else abs(gap) > self.g0

        while t < duration:
            ahead = self.step(z, h, side, touched)
            if not left(ahead):
                z, t = ahead, t + h
                times.append(t)
                wheel.append(degrees(z[0]))
                continue
            short, long = 0.0, h
            for _ in range(45):
                middle = (short + long) / 2
                short, long = (
                    (short, middle) if left(self.step(z, middle, side, touched))
                    else (middle, long)
                )  # fmt: skip
            z, t = self.step(z, long, side, touched), t + long
            if side:
                side = 0
            else:
                gap, rate, _ = self.gap(z)
                side, touched = (1 if gap > 0 else -1), abs(rate)
                at.append(t)
                speeds.append(touched)
        return times, wheel, at, speeds
