//! The geometry of a pinhole camera on a pan/tilt mount.
//!
//! World frame: x to the right, y outwards from the arm's back-plane, z up; metres. Image frame: u to the
//! right, v down, in pixels from the top left corner; a pixel's centre is at (+0.5, +0.5). With pan and tilt
//! zero the camera looks straight down with world x to the right and world y up in the picture.

use nalgebra::{Matrix3, Point3, Vector3};
use thiserror::Error;

use crate::image::SIDE_PX_MAX;

/// Points nearer than this in front of the camera, or behind it, are not projected.
const DEPTH_M_MIN: f64 = 1e-6;

/// Position, direction and field of view of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSetup {
    /// The pinhole in the world, in metres.
    pub position_m: Point3<f64>,
    /// Turn to the right (towards world +x), in radians.
    pub pan_rad: f64,
    /// Turn outwards (towards world +y), in radians.
    pub tilt_rad: f64,
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Width of the picture in pixels.
    pub width_px: usize,
    /// Height of the picture in pixels.
    pub height_px: usize,
}

/// Why a set-up is not a camera.
#[derive(Debug, Error, PartialEq)]
pub enum CameraError {
    /// A number is not finite, or a size is out of range.
    #[error(
        "the camera's {what} is {value}: it must be {expected}; correct it in the world or camera configuration"
    )]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The values it may have.
        expected: &'static str,
    },
}

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    setup: CameraSetup,
    /// Columns: the image's right, the image's down and the optical axis, in the world.
    world_from_camera: Matrix3<f64>,
}

impl Camera {
    /// A camera from its set-up.
    ///
    /// # Errors
    /// When a number is not finite or a size is out of range.
    pub fn new(setup: CameraSetup) -> Result<Self, CameraError> {
        for (what, value) in [
            ("position x", setup.position_m.x),
            ("position y", setup.position_m.y),
            ("position z", setup.position_m.z),
            ("pan", setup.pan_rad),
            ("tilt", setup.tilt_rad),
        ] {
            if !value.is_finite() {
                return Err(CameraError::OutOfRange { what, value, expected: "finite" });
            }
        }
        if !(setup.focal_px.is_finite() && setup.focal_px > 0.0) {
            let value = setup.focal_px;
            return Err(CameraError::OutOfRange { what: "focal length", value, expected: "above zero" });
        }
        for (what, side) in [("width", setup.width_px), ("height", setup.height_px)] {
            if !(1..=SIDE_PX_MAX).contains(&side) {
                let value = side as f64;
                return Err(CameraError::OutOfRange { what, value, expected: "1 to 4096 pixels" });
            }
        }
        Ok(Self { setup, world_from_camera: world_from_camera(setup.pan_rad, setup.tilt_rad) })
    }

    /// The set-up that the camera was made from.
    #[must_use]
    pub fn setup(&self) -> &CameraSetup {
        &self.setup
    }

    /// The position in the picture at which a point of the world is seen: (u, v) in pixels, possibly beyond the
    /// picture's edges. None when the point is not in front of the camera.
    #[must_use]
    pub fn project(&self, point_m: &Point3<f64>) -> Option<(f64, f64)> {
        let in_camera = self.world_from_camera.transpose() * (point_m - self.setup.position_m);
        if in_camera.z < DEPTH_M_MIN {
            return None;
        }
        let (centre_u, centre_v) = self.centre_px();
        let scale = self.setup.focal_px / in_camera.z;
        Some((centre_u + scale * in_camera.x, centre_v + scale * in_camera.y))
    }

    /// How far in front of the camera a point is, along the optical axis, in metres.
    #[must_use]
    pub fn depth_m(&self, point_m: &Point3<f64>) -> f64 {
        self.world_from_camera.column(2).dot(&(point_m - self.setup.position_m))
    }

    /// The ray from the camera through picture position (u, v), in the world, scaled so that a multiple of
    /// it is that depth along the optical axis. Linear in u and v.
    #[must_use]
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        let (centre_u, centre_v) = self.centre_px();
        let focal = self.setup.focal_px;
        self.world_from_camera * Vector3::new((u - centre_u) / focal, (v - centre_v) / focal, 1.0)
    }

    /// Where the ray through (u, v) meets the horizontal plane at `height_m`, if it does.
    #[must_use]
    pub fn on_plane(&self, u: f64, v: f64, height_m: f64) -> Option<Point3<f64>> {
        let ray = self.ray(u, v);
        let depth = (height_m - self.setup.position_m.z) / ray.z;
        (depth.is_finite() && depth > DEPTH_M_MIN).then(|| self.setup.position_m + ray * depth)
    }

    fn centre_px(&self) -> (f64, f64) {
        (self.setup.width_px as f64 / 2.0, self.setup.height_px as f64 / 2.0)
    }
}

fn world_from_camera(pan_rad: f64, tilt_rad: f64) -> Matrix3<f64> {
    let straight_down = Matrix3::from_columns(&[Vector3::x(), -Vector3::y(), -Vector3::z()]);
    let (sin_tilt, cos_tilt) = libm::sincos(tilt_rad);
    let (sin_pan, cos_pan) = libm::sincos(pan_rad);
    // Tilt turns -z towards +y (about world x), pan turns -z towards +x (about world y).
    let tilt = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos_tilt, -sin_tilt, 0.0, sin_tilt, cos_tilt);
    let pan = Matrix3::new(cos_pan, 0.0, -sin_pan, 0.0, 1.0, 0.0, sin_pan, 0.0, cos_pan);
    pan * tilt * straight_down
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(pan_rad: f64, tilt_rad: f64) -> CameraSetup {
        let position_m = Point3::new(0.1, 0.5, 1.2);
        CameraSetup { position_m, pan_rad, tilt_rad, focal_px: 800.0, width_px: 780, height_px: 580 }
    }

    #[test]
    fn straight_down_world_y_is_up_in_the_picture() {
        let camera = Camera::new(setup(0.0, 0.0)).unwrap();
        let (u, v) = camera.project(&Point3::new(0.1, 0.5, 0.0)).unwrap();
        assert!((u - 390.0).abs() < 1e-9 && (v - 290.0).abs() < 1e-9);
        let (right, _) = camera.project(&Point3::new(0.2, 0.5, 0.0)).unwrap();
        let (_, up) = camera.project(&Point3::new(0.1, 0.6, 0.0)).unwrap();
        assert!(right > u && up < v);
    }

    #[test]
    fn pan_looks_right_and_tilt_looks_out() {
        let panned = Camera::new(setup(0.2, 0.0)).unwrap().on_plane(390.0, 290.0, 0.0).unwrap();
        let tilted = Camera::new(setup(0.0, 0.2)).unwrap().on_plane(390.0, 290.0, 0.0).unwrap();
        assert!(panned.x > 0.3 && (panned.y - 0.5).abs() < 1e-9, "{panned}");
        assert!(tilted.y > 0.7 && (tilted.x - 0.1).abs() < 1e-9, "{tilted}");
    }

    #[test]
    fn projecting_undoes_the_ray() {
        let camera = Camera::new(setup(0.15, -0.1)).unwrap();
        for (u, v) in [(0.0, 0.0), (780.0, 580.0), (123.4, 456.7)] {
            let point = camera.on_plane(u, v, 0.05).unwrap();
            let (u2, v2) = camera.project(&point).unwrap();
            assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9);
            let depth = camera.depth_m(&point);
            assert!((camera.setup().position_m + camera.ray(u, v) * depth - point).norm() < 1e-12);
        }
    }

    #[test]
    fn nonsense_is_refused_and_what_is_behind_is_not_seen() {
        assert!(Camera::new(CameraSetup { focal_px: 0.0, ..setup(0.0, 0.0) }).is_err());
        assert!(Camera::new(setup(f64::NAN, 0.0)).is_err());
        let camera = Camera::new(setup(0.0, 0.0)).unwrap();
        assert_eq!(camera.project(&Point3::new(0.1, 0.5, 1.3)), None);
    }
}
