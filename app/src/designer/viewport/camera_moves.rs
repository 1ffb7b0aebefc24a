//! How gestures move a camera: orbit, pan, zoom, fit. Pure functions on [`CameraDesign`]; lengths in mm, angles in
//! degrees, positions in pixels from the picture's top left corner.

use glam::{BVec3, DVec2, DVec3};
use renderer_core::design::{CameraDesign, Design};
use renderer_core::geometry::{Camera, Projection};
use renderer_core::scene::bent_box;

/// A view that every cloth has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StandardView {
    /// Straight down on the front.
    Front,
    /// Straight up at the back.
    Back,
    /// From the near edge, at an angle.
    Angle,
    /// A dozen loops fill the picture.
    Macro,
}

impl StandardView {
    /// All of them, in menu order.
    pub const ALL: [Self; 4] = [Self::Front, Self::Back, Self::Angle, Self::Macro];

    /// Name in menus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "Front",
            Self::Back => "Back",
            Self::Angle => "Angle",
            Self::Macro => "Macro",
        }
    }

    /// What it shows.
    pub fn what(self) -> &'static str {
        match self {
            Self::Front => "Looks straight down on the front of the cloth.",
            Self::Back => "Looks straight at the back of the cloth.",
            Self::Angle => "Looks at the whole cloth from its near edge.",
            Self::Macro => "Looks at a few loops from close by.",
        }
    }
}

/// Turns the camera about its target by angles in degrees.
pub fn orbit(camera: &mut CameraDesign, right: f64, up: f64) {
    let range = CameraDesign::FIELDS.elevation;
    camera.azimuth = (camera.azimuth + right + 180.0).rem_euclid(360.0) - 180.0;
    camera.elevation = (camera.elevation + up).clamp(range.min, range.max);
}

/// Moves the camera so that what was seen at `from` is seen at `to`: along the cloth, or across the view where that is
/// seen too obliquely.
pub fn pan(camera: &mut CameraDesign, from: DVec2, to: DVec2, size: [u32; 2]) {
    let view = Camera::from_design(camera);
    let target = DVec3::from_array(camera.target);
    let on_cloth = |pixel| hit(&view, pixel, size, target, DVec3::Z);
    let across = |pixel| hit(&view, pixel, size, target, view.forward);
    // Below 15° a step on the screen would be a leap on the cloth.
    let oblique = view.forward.z.abs() < 0.26;
    let (start, end) = if oblique {
        (across(from), across(to))
    } else {
        (on_cloth(from), on_cloth(to))
    };
    if let (Some(start), Some(end)) = (start, end) {
        move_target(camera, target + start - end);
    }
}

/// Brings the camera nearer by `factor` (above 1) or farther, keeping what is seen at `pixel` where it is.
pub fn zoom(camera: &mut CameraDesign, factor: f64, pixel: DVec2, size: [u32; 2]) {
    if factor.is_nan() || factor <= 0.0 {
        return;
    }
    let view = Camera::from_design(camera);
    let target = DVec3::from_array(camera.target);
    let fixed = hit(&view, pixel, size, target, DVec3::Z)
        // A far hit near the horizon would throw the target across the land.
        .filter(|p| (p - target).length() < 2.0 * camera.distance)
        .or_else(|| hit(&view, pixel, size, target, view.forward))
        .unwrap_or(target);
    let range = CameraDesign::FIELDS.distance;
    let distance = (camera.distance / factor).clamp(range.min, range.max);
    let scale = distance / camera.distance;
    camera.distance = distance;
    if let Some(height) = &mut camera.orthographic_height {
        *height = (*height * scale).clamp(1e-3, 1e6);
    }
    move_target(camera, fixed + (target - fixed) * scale);
}

/// Least and greatest corner of the box that holds the cloth.
fn cloth_box(design: &Design) -> [DVec3; 2] {
    if let Some(bent) = bent_box(design) {
        return bent;
    }
    let half = DVec3::new(
        f64::from(design.sheet.warps) * design.sheet.pitch_x() / 2.0,
        f64::from(design.sheet.wefts) * design.sheet.pitch_y() / 2.0,
        design.length.longest().min(design.pile.max_length),
    );
    [-half, half]
}

/// Corners of a box.
fn corners([low, high]: [DVec3; 2]) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |k| {
        let is_high = |bit: u32| k >> bit & 1 == 1;
        DVec3::select(BVec3::new(is_high(0), is_high(1), is_high(2)), high, low)
    })
}

/// Whether a picture of `size` pixels shows the whole cloth.
pub fn shows_all(camera: &CameraDesign, design: &Design, size: [u32; 2]) -> bool {
    let view = Camera::from_design(camera);
    let target = DVec3::from_array(camera.target);
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    corners(cloth_box(design)).all(|corner| {
        let from_target = corner - target;
        let half_height = match view.projection {
            Projection::Perspective { fov } => {
                (camera.distance + from_target.dot(view.forward)) * (fov / 2.0).tan()
            }
            Projection::Orthographic { height_mm } => height_mm / 2.0,
        };
        let (x, y) = (from_target.dot(view.right), from_target.dot(view.up));
        x.abs() <= half_height * aspect && y.abs() <= half_height
    })
}

/// Moves the camera back and to the middle until the whole cloth is in a picture of `size` pixels.
pub fn fit(camera: &mut CameraDesign, design: &Design, size: [u32; 2]) {
    let cloth = cloth_box(design);
    let middle = 0.5 * (cloth[0] + cloth[1]);
    camera.target = middle.to_array();
    let view = Camera::from_design(camera);
    let corners = corners(cloth).map(|corner| {
        let corner = corner - middle;
        DVec3::new(
            corner.dot(view.right).abs(),
            corner.dot(view.up).abs(),
            corner.dot(view.forward),
        )
    });
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    // A little air around the cloth.
    let margin = 1.04;
    let range = CameraDesign::FIELDS.distance;
    if let Some(height) = &mut camera.orthographic_height {
        let needed = corners.fold(0.0_f64, |h, c| h.max(2.0 * c.y).max(2.0 * c.x / aspect));
        *height = (needed * margin).clamp(1e-3, 1e6);
    } else {
        let tangent = (camera.fov.to_radians() / 2.0).tan();
        let needed = corners.fold(0.0_f64, |d, c| {
            d.max(c.y / tangent - c.z)
                .max(c.x / (tangent * aspect) - c.z)
        });
        camera.distance = (needed * margin).clamp(range.min, range.max);
    }
}

/// The camera of a standard view of `design`, with the lens of `lens`.
pub fn standard(
    view: StandardView,
    lens: &CameraDesign,
    design: &Design,
    size: [u32; 2],
) -> CameraDesign {
    let mut camera = CameraDesign {
        azimuth: -90.0,
        elevation: match view {
            StandardView::Front => 90.0,
            StandardView::Back => -90.0,
            StandardView::Angle => 35.0,
            StandardView::Macro => 50.0,
        },
        ..lens.clone()
    };
    fit(&mut camera, design, size);
    if view == StandardView::Macro {
        let shown_mm = 12.0 * design.sheet.pitch_x().max(design.sheet.pitch_y());
        if let Some(height) = &mut camera.orthographic_height {
            *height = height.min(shown_mm);
        } else {
            let distance = shown_mm / (2.0 * (camera.fov.to_radians() / 2.0).tan());
            camera.distance = camera.distance.min(distance);
        }
        camera.target[2] = (design.length.longest().min(design.pile.max_length)) / 2.0;
    }
    camera
}

/// Millimetres of cloth over the height of the picture, in the plane through the target.
pub fn picture_height_mm(camera: &CameraDesign) -> f64 {
    match Camera::from_design(camera).projection {
        Projection::Perspective { fov } => 2.0 * camera.distance * (fov / 2.0).tan(),
        Projection::Orthographic { height_mm } => height_mm,
    }
}

/// Moves a perspective camera to where its picture is so high in the plane through the target.
pub fn set_distance_for_height(camera: &mut CameraDesign, height_mm: f64) {
    let range = CameraDesign::FIELDS.distance;
    let distance = height_mm / (2.0 * (camera.fov.to_radians() / 2.0).tan());
    camera.distance = distance.clamp(range.min, range.max);
}

fn move_target(camera: &mut CameraDesign, target: DVec3) {
    if target.is_finite() && target.abs().max_element() <= 1e6 {
        camera.target = target.to_array();
    }
}

/// Where the ray through `pixel` meets the plane through `point` with the normal `normal`, ahead of the eye.
fn hit(view: &Camera, pixel: DVec2, size: [u32; 2], point: DVec3, normal: DVec3) -> Option<DVec3> {
    let (origin, direction) = view.ray(pixel, size);
    let distance = (point - origin).dot(normal) / direction.dot(normal);
    (distance.is_finite() && distance > 0.0).then(|| origin + direction * distance)
}
