//! The way of the arm from one precision point through others to the last. As in V+, all joints begin and end together,
//! and continuous path is on, so that the speed does not drop at the points between.
//!
//! Corners are not rounded off here as a controller rounds them; the points are passed exactly.

/// Joints of the emulated arm: yaw, shoulder, elbow, wrist.
pub const JOINTS: usize = 4;

/// A precision point: one value a joint, in degrees from the home sensors.
pub type Joints = [f64; JOINTS];

/// Time from standing still to the speed asked for, in seconds.
const ACCELERATION_S: f64 = 0.15;
/// Time from full speed to standing still when braking, in seconds.
const BRAKING_S: f64 = 0.06;
/// The slowest speed at the very end of a path, as a share of the speed asked for.
const RATE_MIN: f64 = 0.02;

/// One part of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leg {
    /// The point where it ends.
    pub(crate) to: Joints,
    /// Share of full joint speed, above 0, at most 1.
    pub(crate) speed: f64,
}

/// A path being followed.
#[derive(Clone, Debug)]
pub(crate) struct JointPath {
    points: Vec<Joints>,
    /// When each point would be passed if speed never had to change, in seconds.
    due_s: Vec<f64>,
    at_s: f64,
    rate: f64,
    braking: bool,
}

impl JointPath {
    /// A path from `from`, standing still. `speeds_deg_per_s` are the joints' full speeds.
    pub(crate) fn new(from: Joints, legs: &[Leg], speeds_deg_per_s: Joints) -> Self {
        let (mut points, mut due_s) = (vec![from], vec![0.0]);
        let (mut at, mut when_s) = (from, 0.0);
        for leg in legs {
            let ways = at.iter().zip(leg.to).zip(speeds_deg_per_s);
            let takes_s = ways.map(|((a, b), full)| (b - a).abs() / (full * leg.speed)).fold(0.0, f64::max);
            when_s += takes_s;
            at = leg.to;
            points.push(at);
            due_s.push(when_s);
        }
        Self { points, due_s, at_s: 0.0, rate: 0.0, braking: false }
    }

    /// Brakes: comes to rest as soon as it can.
    pub(crate) fn brake(&mut self) {
        self.braking = true;
    }

    /// Whether the arm stands still for good.
    pub(crate) fn is_over(&self) -> bool {
        (self.braking && self.rate <= 0.0) || self.at_s >= self.end_s()
    }

    /// Whether the last point was reached.
    pub(crate) fn has_arrived(&self) -> bool {
        self.at_s >= self.end_s()
    }

    fn end_s(&self) -> f64 {
        self.due_s.last().copied().unwrap_or(0.0)
    }

    /// Goes on for `time_s`. Returns the joints after that.
    pub(crate) fn advance(&mut self, time_s: f64) -> Joints {
        let left_s = (self.end_s() - self.at_s).max(0.0);
        if self.braking {
            self.rate = (self.rate - time_s / BRAKING_S).max(0.0);
        } else {
            // The rate from which the arm can just come to rest at the end.
            let stopping = (2.0 * left_s / ACCELERATION_S).sqrt();
            let faster = (self.rate + time_s / ACCELERATION_S).min(1.0);
            self.rate = faster.min(stopping).max(RATE_MIN);
        }
        self.at_s = (self.at_s + self.rate * time_s).min(self.end_s());
        self.here()
    }

    fn here(&self) -> Joints {
        let next = self.due_s.partition_point(|due_s| *due_s < self.at_s);
        let (Some(to), Some(to_s)) = (self.points.get(next), self.due_s.get(next)) else {
            return self.points.last().copied().unwrap_or_default();
        };
        let before = next.checked_sub(1).and_then(|at| Some((self.points.get(at)?, self.due_s.get(at)?)));
        let Some((from, from_s)) = before else { return *to };
        let share = if to_s > from_s { (self.at_s - from_s) / (to_s - from_s) } else { 1.0 };
        let mut here = *to;
        if share < 1.0 {
            here.iter_mut().zip(from).for_each(|(value, from)| *value = from + (*value - from) * share);
        }
        here
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Joints = [100.0, 50.0, 50.0, 100.0];
    const DT: f64 = 1.0 / 240.0;

    fn followed(mut path: JointPath) -> Vec<Joints> {
        let mut way = Vec::new();
        while !path.is_over() {
            way.push(path.advance(DT));
            assert!(way.len() < 100_000, "it never ends");
        }
        way
    }

    #[test]
    fn it_passes_its_points_and_ends_exactly_at_the_last_within_every_speed_limit() {
        let from = [0.0, 10.0, -20.0, 0.0];
        let legs = [
            Leg { to: [30.0, 12.0, -10.0, 5.0], speed: 0.5 },
            Leg { to: [30.0, -12.0, -10.0, 5.0], speed: 1.0 },
            Leg { to: [31.0, -12.0, -11.0, 4.0], speed: 0.1 },
        ];
        let way = followed(JointPath::new(from, &legs, FULL));
        assert_eq!(way.last(), Some(&legs[2].to));
        let corner = way.iter().map(|at| (at[1] - 12.0).abs() + (at[0] - 30.0).abs());
        assert!(corner.fold(f64::INFINITY, f64::min) < 0.5, "it passes the point between");
        for pair in way.windows(2) {
            for joint in 0..JOINTS {
                let speed = (pair[1][joint] - pair[0][joint]).abs() / DT;
                assert!(speed <= FULL[joint] * 1.001, "joint {joint} at {speed} deg/s");
            }
        }
        let took_s = way.len() as f64 * DT;
        assert!((1.2..2.2).contains(&took_s), "{took_s} s");
    }

    #[test]
    fn braked_it_stops_within_a_moment_and_has_not_arrived() {
        let mut path = JointPath::new([0.0; 4], &[Leg { to: [90.0, 0.0, 0.0, 0.0], speed: 1.0 }], FULL);
        for _ in 0..120 {
            path.advance(DT);
        }
        let before = path.advance(DT)[0];
        path.brake();
        let way = followed(path.clone());
        let after = way.last().unwrap()[0];
        assert!(way.len() <= 16 && after - before < 4.0 && after < 90.0, "{before} to {after}");
    }

    #[test]
    fn a_path_to_where_it_is_ends_at_once() {
        let path = JointPath::new([1.0; 4], &[Leg { to: [1.0; 4], speed: 0.2 }], FULL);
        assert!(path.is_over() && path.has_arrived());
    }
}
