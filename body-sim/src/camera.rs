//! A small renderer of the camera's picture. Every solid is tested ray by ray within the part of the picture that it
//! can cover, the nearest surface wins, and light falls from the left behind and throws shadows on the table. The table
//! and the solids fixed to it never change and are drawn once. Before a new picture only the pixels that the last one
//! had drawn upon are wiped.

use std::ops::Range;

use nalgebra::{Isometry3, Point3, Vector3};
use pschema_vision::camera::Camera;
use pschema_vision::image::{ImageError, RgbImage};

type Vec3 = Vector3<f32>;

/// Colours of the table top, its printed lines and the floor around it.
const TABLE_RGB: [f32; 3] = [206.0, 202.0, 194.0];
const LINE_RGB: [f32; 3] = [188.0, 184.0, 177.0];
const FLOOR_RGB: [f32; 3] = [92.0, 93.0, 96.0];
/// The table's lines are this far apart and this wide, in metres.
const LINE_PITCH_M: f64 = 0.1;
const LINE_WIDTH_M: f64 = 0.003;
/// Brightness of the light that is everywhere, and of the lamp's on a surface that faces it.
const AMBIENT: f32 = 0.42;
const LAMP: f32 = 0.62;
/// Share of the light that is left in a shadow.
const SHADOW: f32 = 0.66;

/// A solid that the camera can see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Its form and place, in metres.
    pub shape: Shape,
    /// Its paint.
    pub rgb: [u8; 3],
}

/// Form and place of a solid, in the world, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A cube: pose of its centre, half its edge.
    Cube(Isometry3<f64>, f64),
    /// All points within a radius of the line between two points; a ball when the two are one.
    Capsule(Point3<f64>, Point3<f64>, f64),
}

/// The table top, at height 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableTop {
    /// Extent along x, centred on 0, in metres.
    pub width_m: f64,
    /// First and last y, in metres.
    pub y_m: (f64, f64),
}

/// Renders pictures of one scene from one camera.
#[derive(Clone, Debug)]
pub struct Renderer {
    camera: Camera,
    eye: Vec3,
    ray: [Vec3; 3],
    light: Vec3,
    backdrop: Layer,
    picture: Layer,
    /// The pixels in which the picture differs from the backdrop, and those in which the picture before did: ranges,
    /// counted row by row.
    drawn: Vec<Range<usize>>,
    drawn_before: Vec<Range<usize>>,
}

/// A picture with the depth and the shading of each pixel, which drawing needs.
#[derive(Clone, Debug)]
struct Layer {
    image: RgbImage,
    depth: Vec<f32>,
    shaded: Vec<bool>,
}

/// The part of the picture within a radius of the line between two points: a capsule can be seen nowhere else.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    from: (f64, f64),
    to: (f64, f64),
    radius: f64,
}

impl Stroke {
    fn rows(&self, height: usize) -> Range<usize> {
        let (top, bottom) = (self.from.1.min(self.to.1), self.from.1.max(self.to.1));
        clipped(top - self.radius, bottom + self.radius, height)
    }

    /// Columns of a row that can be within the stroke.
    fn columns(&self, row: usize, width: usize) -> Range<usize> {
        let (du, dv) = (self.to.0 - self.from.0, self.to.1 - self.from.1);
        let off = row as f64 + 0.5 - self.from.1;
        // Shares of the line that are within the radius of this row.
        let (first, last) = if dv.abs() < 1e-9 {
            (0.0, 1.0)
        } else {
            let (a, b) = ((off - self.radius) / dv, (off + self.radius) / dv);
            (a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, 1.0))
        };
        let (a, b) = (self.from.0 + du * first, self.from.0 + du * last);
        clipped(a.min(b) - self.radius, a.max(b) + self.radius, width)
    }
}

fn clipped(from: f64, to: f64, side: usize) -> Range<usize> {
    let clip = |x: f64| x.clamp(0.0, side as f64) as usize;
    clip(from)..clip(to.ceil())
}

impl Renderer {
    /// A renderer, with the table and what is fixed to it drawn.
    ///
    /// # Errors
    /// When the camera's picture has no allowed size.
    pub fn new(camera: &Camera, table: TableTop, fixed: &[Solid]) -> Result<Self, ImageError> {
        let (width, height) = (camera.setup().width_px, camera.setup().height_px);
        let empty = Layer {
            image: draw_table(camera, table)?,
            depth: vec![f32::INFINITY; width * height],
            shaded: vec![false; width * height],
        };
        let first = camera.ray(0.5, 0.5);
        let mut renderer = Self {
            eye: narrow(&camera.setup().position_m.coords),
            // A ray is linear in column and row: the first pixel's, and the steps to the next.
            ray: [first, camera.ray(1.5, 0.5) - first, camera.ray(0.5, 1.5) - first].map(|ray| narrow(&ray)),
            light: Vec3::new(-0.42, -0.30, 0.856),
            picture: empty.clone(),
            backdrop: empty,
            drawn: Vec::new(),
            drawn_before: Vec::new(),
            camera: camera.clone(),
        };
        renderer.draw_all(fixed);
        renderer.backdrop = renderer.picture.clone();
        renderer.drawn.clear();
        Ok(renderer)
    }

    /// The picture of these solids on the table.
    pub fn render(&mut self, solids: &[Solid]) -> &RgbImage {
        std::mem::swap(&mut self.drawn, &mut self.drawn_before);
        self.drawn.clear();
        for part in &self.drawn_before {
            let part = part.clone();
            self.picture.image.pixels_mut()[part.clone()]
                .copy_from_slice(&self.backdrop.image.pixels()[part.clone()]);
            self.picture.depth[part.clone()].copy_from_slice(&self.backdrop.depth[part.clone()]);
            self.picture.shaded[part.clone()].copy_from_slice(&self.backdrop.shaded[part]);
        }
        self.draw_all(solids);
        &self.picture.image
    }

    /// The picture rendered last.
    #[must_use]
    pub fn image(&self) -> &RgbImage {
        &self.picture.image
    }

    /// The pixels in which the picture may differ from the one before: ranges, counted row by row, in no order.
    pub fn changed(&self) -> impl Iterator<Item = &Range<usize>> {
        self.drawn_before.iter().chain(&self.drawn)
    }

    fn draw_all(&mut self, solids: &[Solid]) {
        let bodies: Vec<Surface> = solids.iter().map(Surface::new).collect();
        for (solid, body) in solids.iter().zip(&bodies) {
            self.draw_shadow(solid, body);
        }
        for (solid, body) in solids.iter().zip(&bodies) {
            self.draw(solid, body);
        }
    }

    fn draw(&mut self, solid: &Solid, body: &Surface) {
        let (from_m, to_m, radius_m) = hull(&solid.shape);
        let Some(stroke) = self.stroke(&from_m, &to_m, radius_m) else { return };
        let (width, height) = (self.picture.image.width_px(), self.picture.image.height_px());
        for row in stroke.rows(height) {
            let columns = stroke.columns(row, width);
            self.drawn.push(row * width + columns.start..row * width + columns.end);
            for column in columns {
                let at = row * width + column;
                let Some((depth, normal)) = body.hit(&self.eye, &self.ray_at(column, row)) else { continue };
                if depth < self.picture.depth[at] {
                    self.picture.depth[at] = depth;
                    let light = AMBIENT + LAMP * normal.dot(&self.light).max(0.0);
                    self.picture.image.pixels_mut()[at] =
                        solid.rgb.map(|c| (f32::from(c) * light).min(255.0) as u8);
                }
            }
        }
    }

    /// Darkens the table where a solid stands between it and the lamp.
    fn draw_shadow(&mut self, solid: &Solid, body: &Surface) {
        let light = self.light;
        // Every point slides down the light onto the table; a ball's shadow is drawn out along the light.
        let slide =
            Vector3::new(f64::from(light.x), f64::from(light.y), f64::from(light.z)) / f64::from(light.z);
        let (from_m, to_m, radius_m) = hull(&solid.shape);
        let (from_m, to_m) = (from_m - slide * from_m.z, to_m - slide * to_m.z);
        let Some(stroke) = self.stroke(&from_m, &to_m, radius_m / f64::from(light.z)) else { return };
        let (width, height) = (self.picture.image.width_px(), self.picture.image.height_px());
        for row in stroke.rows(height) {
            let columns = stroke.columns(row, width);
            self.drawn.push(row * width + columns.start..row * width + columns.end);
            for column in columns {
                let at = row * width + column;
                let ray = self.ray_at(column, row);
                // A fixed solid stands before the table here.
                let covered = self.picture.depth[at].is_finite();
                if self.picture.shaded[at] || covered || ray.z >= 0.0 {
                    continue;
                }
                let ground = self.eye + ray * (-self.eye.z / ray.z);
                if body.hit(&ground, &light).is_some() {
                    self.picture.shaded[at] = true;
                    let pixel = &mut self.picture.image.pixels_mut()[at];
                    *pixel = pixel.map(|c| (f32::from(c) * SHADOW) as u8);
                }
            }
        }
    }

    fn ray_at(&self, column: usize, row: usize) -> Vec3 {
        self.ray[0] + self.ray[1] * column as f32 + self.ray[2] * row as f32
    }

    /// Where a capsule can be seen. None when some of it is not in front of the camera.
    fn stroke(&self, from_m: &Point3<f64>, to_m: &Point3<f64>, radius_m: f64) -> Option<Stroke> {
        let (from, to) = (self.camera.project(from_m)?, self.camera.project(to_m)?);
        let depth_m = self.camera.depth_m(from_m).min(self.camera.depth_m(to_m)) - radius_m;
        if depth_m <= 0.0 {
            return None;
        }
        // Away from the axis a ball's picture is drawn out, by at most the secant of the angle squared.
        let setup = self.camera.setup();
        let secant_squared = |(u, v): (f64, f64)| {
            let (du, dv) = (u - setup.width_px as f64 / 2.0, v - setup.height_px as f64 / 2.0);
            1.0 + (du * du + dv * dv) / (setup.focal_px * setup.focal_px)
        };
        let drawn_out = secant_squared(from).max(secant_squared(to));
        Some(Stroke { from, to, radius: radius_m * setup.focal_px / depth_m * drawn_out + 1.0 })
    }
}

/// A capsule around a shape: the ends of its axis and its radius.
fn hull(shape: &Shape) -> (Point3<f64>, Point3<f64>, f64) {
    match *shape {
        // The cube's half diagonal: the square root of 3, rounded up.
        Shape::Cube(pose, half_m) => {
            let centre = Point3::from(pose.translation.vector);
            (centre, centre, half_m * 1.733)
        }
        Shape::Capsule(a, b, radius_m) => (a, b, radius_m),
    }
}

/// The surface of a solid, made ready for rays.
enum Surface {
    Cube { centre: Vec3, axes: [Vec3; 3], half: f32 },
    Capsule { a: Vec3, axis: Vec3, axis_squared: f32, radius: f32 },
}

impl Surface {
    fn new(solid: &Solid) -> Self {
        match solid.shape {
            Shape::Cube(pose, half_m) => {
                let turned = pose.rotation.to_rotation_matrix();
                let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| narrow(&(turned * axis)));
                Self::Cube { centre: narrow(&pose.translation.vector), axes, half: half_m as f32 }
            }
            Shape::Capsule(a, b, radius_m) => {
                let axis = narrow(&(b - a));
                let axis_squared = axis.norm_squared();
                Self::Capsule { a: narrow(&a.coords), axis, axis_squared, radius: radius_m as f32 }
            }
        }
    }

    /// The point where a ray from outside first meets the surface, in lengths of the ray, and the surface's normal
    /// there.
    fn hit(&self, origin: &Vec3, ray: &Vec3) -> Option<(f32, Vec3)> {
        match self {
            Self::Cube { centre, axes, half } => hit_cube(&(origin - centre), ray, axes, *half),
            Self::Capsule { a, axis, axis_squared, radius } => {
                let from_a = origin - a;
                let distance = hit_capsule(&from_a, ray, axis, *axis_squared, *radius)?;
                let point = from_a + ray * distance;
                let along =
                    if *axis_squared > 0.0 { (point.dot(axis) / axis_squared).clamp(0.0, 1.0) } else { 0.0 };
                Some((distance, (point - axis * along) / *radius))
            }
        }
    }
}

/// Slab test in the cube's own axes.
fn hit_cube(from_centre: &Vec3, ray: &Vec3, axes: &[Vec3; 3], half: f32) -> Option<(f32, Vec3)> {
    let (mut enter, mut leave, mut normal) = (f32::MIN, f32::MAX, Vec3::zeros());
    for axis in axes {
        let (start, speed) = (from_centre.dot(axis), ray.dot(axis));
        // A ray along the slab divides by zero: infinities of the right sign, or none at all.
        let (first, last) = ((-half - start) / speed, (half - start) / speed);
        let (near, far) = (first.min(last), first.max(last));
        if near > enter {
            enter = near;
            normal = if speed > 0.0 { -axis } else { *axis };
        }
        leave = leave.min(far);
    }
    (enter <= leave && enter > 0.0).then_some((enter, normal))
}

/// The cylinder's side where the ray meets it between the ends, else the nearer end's ball.
fn hit_capsule(from_a: &Vec3, ray: &Vec3, axis: &Vec3, axis_squared: f32, radius: f32) -> Option<f32> {
    let ray_squared = ray.norm_squared();
    let ball = |from_centre: &Vec3| {
        let b = from_centre.dot(ray);
        let c = from_centre.norm_squared() - radius * radius;
        let discriminant = b * b - ray_squared * c;
        let distance = (-b - discriminant.max(0.0).sqrt()) / ray_squared;
        (discriminant >= 0.0 && distance > 0.0).then_some(distance)
    };
    if axis_squared <= radius * radius * 1e-6 {
        return ball(from_a);
    }
    let (axis_ray, axis_from) = (axis.dot(ray), axis.dot(from_a));
    let a = axis_squared * ray_squared - axis_ray * axis_ray;
    let b = axis_squared * from_a.dot(ray) - axis_from * axis_ray;
    let c = axis_squared * (from_a.norm_squared() - radius * radius) - axis_from * axis_from;
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    if a > 0.0 {
        let distance = (-b - discriminant.sqrt()) / a;
        let along = axis_from + distance * axis_ray;
        if distance > 0.0 && (0.0..=axis_squared).contains(&along) {
            return Some(distance);
        }
    }
    match (ball(from_a), ball(&(from_a - axis))) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}

fn draw_table(camera: &Camera, table: TableTop) -> Result<RgbImage, ImageError> {
    let (width, height) = (camera.setup().width_px, camera.setup().height_px);
    let mut image = RgbImage::new(width, height)?;
    for (at, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let (u, v) = ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        let rgb = match camera.on_plane(u, v, 0.0) {
            Some(p) if p.x.abs() <= table.width_m / 2.0 && (table.y_m.0..=table.y_m.1).contains(&p.y) => {
                if on_line(p.x) || on_line(p.y) {
                    LINE_RGB
                } else {
                    TABLE_RGB
                }
            }
            _ => FLOOR_RGB,
        };
        // A little grain, the same in every picture, as no surface is quite even.
        let grain = ((at as u32).wrapping_mul(2_654_435_761) >> 29) as f32 - 3.5;
        *pixel = rgb.map(|c| (c + grain * 0.8) as u8);
    }
    Ok(image)
}

fn on_line(coordinate_m: f64) -> bool {
    let from_line = coordinate_m - (coordinate_m / LINE_PITCH_M).round() * LINE_PITCH_M;
    from_line.abs() < LINE_WIDTH_M / 2.0
}

fn narrow(vector: &Vector3<f64>) -> Vec3 {
    vector.map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pschema_vision::camera::CameraSetup;

    fn renderer() -> Renderer {
        let setup = CameraSetup {
            position_m: Point3::new(0.0, 0.0, 1.2),
            pan_rad: 0.0,
            tilt_rad: 0.0,
            focal_px: 800.0,
            width_px: 780,
            height_px: 580,
        };
        Renderer::new(&Camera::new(setup).unwrap(), TableTop { width_m: 3.0, y_m: (-2.0, 2.0) }, &[]).unwrap()
    }

    fn red_pixels(image: &RgbImage) -> Vec<(f64, f64)> {
        let width = image.width_px();
        let red = |p: &[u8; 3]| p[0] > 60 && p[1] == 0;
        let positions = image.pixels().iter().enumerate().filter(|(_, p)| red(p));
        positions.map(|(at, _)| ((at % width) as f64 + 0.5, (at / width) as f64 + 0.5)).collect()
    }

    #[test]
    fn a_ball_is_seen_where_it_is_and_as_large_as_it_is() {
        let mut renderer = renderer();
        let ball = Point3::new(0.2, 0.1, 0.2);
        let image = renderer.render(&[Solid { shape: Shape::Capsule(ball, ball, 0.05), rgb: [255, 0, 0] }]);
        let seen = red_pixels(image);
        let radius_px = 0.05 * 800.0 / 1.0;
        let area = std::f64::consts::PI * radius_px * radius_px;
        assert!((seen.len() as f64 / area - 1.0).abs() < 0.08, "{} against {area}", seen.len());
        let (u, v) = seen.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        let (u, v) = (u / seen.len() as f64, v / seen.len() as f64);
        assert!((u - (390.0 + 160.0)).abs() < 1.0 && (v - (290.0 - 80.0)).abs() < 1.0, "({u}, {v})");
    }

    #[test]
    fn no_part_of_a_shape_is_cut_off_by_its_windows() {
        let mut renderer = renderer();
        let turned = Isometry3::new(Vector3::new(-0.45, -0.3, 0.1), Vector3::new(0.3, 0.7, 1.1));
        let (a, b) = (Point3::new(-0.5, 0.35, 0.3), Point3::new(0.5, -0.1, 0.02));
        for shape in [Shape::Cube(turned, 0.06), Shape::Capsule(a, b, 0.02)] {
            let solid = Solid { shape, rgb: [255, 0, 0] };
            let windowed = red_pixels(renderer.render(&[solid])).len();
            let body = Surface::new(&solid);
            let everywhere = (0..580)
                .flat_map(|row| (0..780).map(move |column| (column, row)))
                .filter(|&(column, row)| body.hit(&renderer.eye, &renderer.ray_at(column, row)).is_some())
                .count();
            assert!(everywhere > 500);
            assert_eq!(windowed, everywhere);
        }
    }

    #[test]
    fn the_nearer_hides_the_farther_whatever_the_order() {
        let mut renderer = renderer();
        let at = |z: f64| Point3::new(0.0, 0.0, z);
        let high = Solid { shape: Shape::Capsule(at(0.3), at(0.3), 0.05), rgb: [255, 0, 0] };
        let low = Solid { shape: Shape::Capsule(at(0.1), at(0.1), 0.05), rgb: [0, 0, 255] };
        let one = renderer.render(&[high, low]).clone();
        assert_eq!(&one, renderer.render(&[low, high]));
        assert!(one.pixels().iter().all(|p| p[2] < 150 || p[0] > 100), "the blue ball is hidden");
    }

    /// Pixels left over from an earlier picture, or changed without notice, would be seen as an object.
    #[test]
    fn a_picture_depends_on_what_is_there_now_alone_and_says_what_changed() {
        let ball = |x: f64, z: f64| {
            let at = Point3::new(x, 0.0, z);
            Solid { shape: Shape::Capsule(at, at, 0.05), rgb: [255, 0, 0] }
        };
        let mut used = renderer();
        let mut before = used.render(&[]).clone();
        for (x, z) in [(0.1, 0.1), (0.13, 0.2), (-0.3, 0.1), (5.0, 0.1)] {
            let image = used.render(&[ball(x, z)]).clone();
            assert_eq!(&image, renderer().render(&[ball(x, z)]));
            let mut changed = vec![false; image.pixels().len()];
            used.changed().for_each(|part| changed[part.clone()].fill(true));
            for (at, (now, then)) in image.pixels().iter().zip(before.pixels()).enumerate() {
                assert!(now == then || changed[at]);
            }
            before = image;
        }
    }

    #[test]
    fn a_solid_throws_a_shadow_on_the_table() {
        let mut renderer = renderer();
        let empty = renderer.render(&[]).clone();
        let ball = Point3::new(0.0, 0.0, 0.1);
        let lit = renderer.render(&[Solid { shape: Shape::Capsule(ball, ball, 0.03), rgb: [255, 0, 0] }]);
        let darker = |(a, b): (&[u8; 3], &[u8; 3])| b[1] > 0 && i32::from(b[1]) < i32::from(a[1]) - 30;
        let shadow = empty.pixels().iter().zip(lit.pixels()).filter(|&pair| darker(pair)).count();
        assert!(shadow > 300, "{shadow}");
    }
}
