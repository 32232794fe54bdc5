//! Rectangles and panels. Lengths are in units of the picture, about a pixel each.

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rect {
    /// Left end.
    pub(crate) x: f64,
    /// Upper end.
    pub(crate) y: f64,
    /// Width.
    pub(crate) w: f64,
    /// Height.
    pub(crate) h: f64,
}

impl Rect {
    pub(crate) fn middle(&self) -> (f64, f64) {
        (self.x + self.w / 2.0, self.y + self.h / 2.0)
    }

    /// The point of its border on the line from its middle to a point.
    pub(crate) fn border(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let (mx, my) = self.middle();
        let (dx, dy) = (x - mx, y - my);
        let ratio = |half: f64, d: f64| if d.abs() < 1e-9 { f64::INFINITY } else { half / d.abs() };
        let scale = ratio(self.w / 2.0, dx).min(ratio(self.h / 2.0, dy)).min(1.0);
        (mx + dx * scale, my + dy * scale)
    }
}

/// The panel of a cluster.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Panel {
    pub(crate) rect: Rect,
    pub(crate) title: String,
}
