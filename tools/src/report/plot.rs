//! Drawings with axes, as SVG: every figure of the report is made of these parts. Colours are classes, so that the
//! page's style decides them for light and dark.

use maud::{Markup, html};

use super::scale::Scale;

/// Colours told apart by everyone, as classes `c0` to `c5` of the style sheet.
pub(super) const COLOURS: usize = 6;

/// Points that one curve is drawn with at most for each pixel of width.
const POINTS_PER_PX: f64 = 2.0;

/// Where a panel lies on its drawing, in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Frame {
    /// Left to right.
    pub(super) fn x(&self) -> (f64, f64) {
        (self.left, self.right)
    }

    /// Bottom to top.
    pub(super) fn y(&self) -> (f64, f64) {
        (self.bottom, self.top)
    }

    fn width(&self) -> f64 {
        self.right - self.left
    }
}

/// A drawing as wide as a page on a desk, and one as wide as a telephone: the style shows one of them.
pub(super) fn both(draw: impl Fn(f64) -> Markup) -> Markup {
    html! {
        div.wide { (draw(720.0)) }
        div.narrow { (draw(360.0)) }
    }
}

/// A whole drawing.
pub(super) fn drawing(width: f64, height: f64, label: &str, content: &Markup) -> Markup {
    html! {
        svg viewBox=(format!("0 0 {width:.0} {height:.0}")) role="img" aria-label=(label) { (content) }
    }
}

/// The axis below a panel, with its label.
pub(super) fn x_axis(frame: &Frame, scale: &Scale, label: &str) -> Markup {
    let count = if frame.width() < 400.0 { 5 } else { 7 };
    html! {
        line.axis x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(frame.bottom)) y2=(px(frame.bottom)) {}
        @for (value, name) in scale.ticks(count) {
            @let x = scale.at(value);
            line.axis x1=(px(x)) x2=(px(x)) y1=(px(frame.bottom)) y2=(px(frame.bottom + 4.0)) {}
            text.tick.middle x=(px(x)) y=(px(frame.bottom + 17.0)) { (name) }
        }
        text.label.middle x=(px(f64::midpoint(frame.left, frame.right))) y=(px(frame.bottom + 34.0)) { (label) }
    }
}

/// The axis beside a panel, with its label at the top of the drawing.
pub(super) fn y_axis(frame: &Frame, scale: &Scale, label: &str) -> Markup {
    html! {
        @for (value, name) in scale.ticks(4) {
            @let y = scale.at(value);
            line.grid x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(y)) y2=(px(y)) {}
            text.tick.end x=(px(frame.left - 6.0)) y=(px(y + 4.0)) { (name) }
        }
        line.axis x1=(px(frame.left)) x2=(px(frame.left)) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
        text.label x="2" y="14" { (label) }
    }
}

/// Points joined by straight lines. Of more points than can be seen, the highest and lowest are drawn.
pub(super) fn curve(points: &[(f64, f64)], x: &Scale, y: &Scale, class: &str) -> Markup {
    let thinned = thinned(points, x);
    html! { path class=(class) d=(path(&thinned, x, y, false)) {} }
}

/// Points joined by level lines that rise and fall at the points.
pub(super) fn steps(points: &[(f64, f64)], x: &Scale, y: &Scale, class: &str) -> Markup {
    let thinned = thinned(points, x);
    html! { path class=(class) d=(path(&thinned, x, y, true)) {} }
}

fn path(points: &[(f64, f64)], x: &Scale, y: &Scale, level: bool) -> String {
    let mut text = String::new();
    let mut last_y = f64::NAN;
    for (at, (px_x, px_y)) in points.iter().map(|(a, b)| (x.at(*a), y.at(*b))).enumerate() {
        if at == 0 {
            text.push_str(&format!("M{} {}", px(px_x), px(px_y)));
        } else if level {
            text.push_str(&format!("H{}", px(px_x)));
            if (px_y - last_y).abs() > 0.05 {
                text.push_str(&format!("V{}", px(px_y)));
            }
        } else {
            text.push_str(&format!("L{} {}", px(px_x), px(px_y)));
        }
        last_y = px_y;
    }
    text
}

/// No more points than a curve can show: of those that share a place along x, the first, lowest, highest and last.
fn thinned(points: &[(f64, f64)], x: &Scale) -> Vec<(f64, f64)> {
    let (from, to) = x.px();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a width in pixels")]
    let places = ((to - from).abs() * POINTS_PER_PX / 2.0) as usize;
    if points.len() <= places * 4 {
        return points.to_vec();
    }
    let mut kept = Vec::new();
    #[expect(clippy::cast_possible_truncation, reason = "a place in pixels")]
    let place = |point: &(f64, f64)| x.at(point.0).round() as i64;
    for shared in points.chunk_by(|a, b| place(a) == place(b)) {
        let mut four = Vec::from_iter(shared.first().copied());
        four.extend(shared.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)));
        four.extend(shared.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)));
        four.extend(shared.last().copied());
        four.sort_by(|a, b| a.0.total_cmp(&b.0));
        four.dedup();
        kept.extend(four);
    }
    kept
}

/// The names of the curves, below one another or side by side; their colours are `c0`, `c1`, … in this order.
pub(super) fn legend(names: &[&str]) -> Markup {
    html! {
        ul.legend {
            @for (at, name) in names.iter().enumerate() {
                li {
                    svg.key viewBox="0 0 26 12" aria-hidden="true" {
                        line class=(format!("curve bold c{}", at % COLOURS)) x1="1" x2="25" y1="6" y2="6" {}
                    }
                    (name)
                }
            }
        }
    }
}

/// A length or place with as many digits as can be seen.
pub(super) fn px(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_keeps_its_extremes() {
        let mut points: Vec<_> = (0..100_000).map(|n| (f64::from(n), 1.0)).collect();
        points[54_321].1 = 9.0;
        points[54_322].1 = -9.0;
        let x = Scale::linear(0.0, 100_000.0, (0.0, 300.0));
        let kept = thinned(&points, &x);
        assert!(kept.len() <= 4 * 302, "{}", kept.len());
        assert!(kept.contains(&(54_321.0, 9.0)) && kept.contains(&(54_322.0, -9.0)));
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
    }

    #[test]
    fn level_lines_rise_at_their_points() {
        let x = Scale::linear(0.0, 2.0, (0.0, 20.0));
        let y = Scale::linear(0.0, 1.0, (10.0, 0.0));
        assert_eq!(path(&[(0.0, 0.0), (1.0, 1.0), (2.0, 1.0)], &x, &y, true), "M0 10H10V0H20");
        assert_eq!(path(&[(0.0, 0.0), (1.0, 1.0)], &x, &y, false), "M0 10L10 0");
        assert_eq!(path(&[], &x, &y, true), "");
    }
}
