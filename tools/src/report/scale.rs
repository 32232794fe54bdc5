//! From figures to places on a drawing, and the figures that an axis names.

use crate::render::words::figure;

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    px_from: f64,
    px_to: f64,
    logarithmic: bool,
}

impl Scale {
    /// From `from` at `px.0` to `to` at `px.1`. An empty range is widened.
    pub(super) fn linear(from: f64, to: f64, px: (f64, f64)) -> Self {
        let to = if to > from { to } else { from + 1.0 };
        Self { from, to, px_from: px.0, px_to: px.1, logarithmic: false }
    }

    /// The same by powers of ten; both ends above 0.
    pub(super) fn logarithmic(from: f64, to: f64, px: (f64, f64)) -> Self {
        let from = from.max(f64::MIN_POSITIVE);
        let to = if to > from { to } else { from * 10.0 };
        Self { from, to, px_from: px.0, px_to: px.1, logarithmic: true }
    }

    /// Where `value` is; beyond the ends, at the end.
    pub(super) fn at(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(self.from).ln() - self.from.ln()) / (self.to.ln() - self.from.ln())
        } else {
            (value - self.from) / (self.to - self.from)
        };
        self.px_from + share.clamp(0.0, 1.0) * (self.px_to - self.px_from)
    }

    /// Where the axis begins and ends on the drawing.
    pub(super) fn px(&self) -> (f64, f64) {
        (self.px_from, self.px_to)
    }

    /// Figures to name, with their names; about `count` of them.
    pub(super) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let values = if self.logarithmic { self.powers(count) } else { self.steps(count) };
        values.into_iter().map(|value| (value, name(value))).collect()
    }

    /// 1, 2 or 5 times a power of ten apart.
    fn steps(&self, count: usize) -> Vec<f64> {
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let raw = (self.to - self.from) / count.max(1) as f64;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= raw * 0.999);
        let step = step.unwrap_or(power * 10.0);
        let first = (self.from / step).ceil();
        let within = |value: &f64| *value <= self.to + step * 1e-9;
        // Never more than twice what was asked for: the step is at least the range over the count.
        (0..=count.max(1) * 2).map(|n| (first + f64::from(n as u32)) * step).take_while(within).collect()
    }

    /// Powers of ten within the ends, and 2 and 5 times them where there are few.
    fn powers(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.from.log10().floor(), self.to.log10().ceil());
        #[expect(clippy::cast_possible_truncation, reason = "exponents of finite numbers")]
        let exponents = (low as i32)..=(high as i32);
        let every = |multiples: &[f64]| -> Vec<f64> {
            let all = exponents.clone().flat_map(|e| multiples.iter().map(move |m| m * 10f64.powi(e)));
            all.filter(|v| *v >= self.from * 0.999 && *v <= self.to * 1.001).collect()
        };
        let finer = every(&[1.0, 2.0, 5.0]);
        if finer.len() <= count + 2 { finer } else { every(&[1.0]) }
    }
}

/// A figure on an axis: `20,000`, `0.5`.
pub(super) fn name(value: f64) -> String {
    if value.abs() >= 10_000.0 {
        return grouped(value);
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let text = figure(value, 3);
    let (digits, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    format!("{}{power}", digits.trim_end_matches('0').trim_end_matches('.'))
}

fn grouped(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if value < 0.0 { format!("-{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(scale: Scale, count: usize) -> Vec<String> {
        scale.ticks(count).into_iter().map(|(_, name)| name).collect()
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(named(Scale::linear(0.0, 330.0, (0.0, 1.0)), 4), ["0", "100", "200", "300"]);
        assert_eq!(named(Scale::linear(0.0, 1.0, (0.0, 1.0)), 4), ["0", "0.5", "1"]);
        assert_eq!(
            named(Scale::linear(0.0, 25_000.0, (0.0, 1.0)), 5),
            ["0", "5000", "10,000", "15,000", "20,000", "25,000"]
        );
        assert_eq!(named(Scale::logarithmic(30.0, 3_000.0, (0.0, 1.0)), 3), ["100", "1000"]);
        assert_eq!(named(Scale::logarithmic(30.0, 300.0, (0.0, 1.0)), 3), ["50", "100", "200"]);
        assert_eq!(named(Scale::linear(0.0, 0.001, (0.0, 1.0)), 2), ["0", "0.0005", "0.001"]);
        assert_eq!(named(Scale::linear(0.0, 2e-7, (0.0, 1.0)), 2), ["0", "1e-7", "2e-7"]);
        assert_eq!(named(Scale::linear(5.0, 5.0, (0.0, 1.0)), 2), ["5", "5.5", "6"]);
    }

    #[test]
    fn values_are_placed_and_never_beyond_the_ends() {
        let scale = Scale::linear(0.0, 10.0, (100.0, 0.0));
        assert_eq!([0.0, 5.0, 10.0, 20.0, -1.0].map(|v| scale.at(v)), [100.0, 50.0, 0.0, 0.0, 100.0]);
        let scale = Scale::logarithmic(1.0, 100.0, (0.0, 2.0));
        assert!((scale.at(10.0) - 1.0).abs() < 1e-9 && scale.at(0.0) == 0.0);
    }
}
