//! What other programs need beside the loops to draw the same picture: yarn, ground, cameras and lights.
//!
//! World space, mm, degrees, linear RGB with sRGB primaries.

use glam::DVec3;
use renderer_core::design::Design;
use renderer_core::geometry::{Camera, Projection};
use renderer_core::scene::{AreaLight, Scene};
use serde::Serialize;

/// Everything but the loops.
#[derive(Debug, Serialize)]
pub struct Surroundings {
    yarn: Yarn,
    ground: Ground,
    /// In the order of the preset; its first is what `render` uses unless another is given.
    cameras: Vec<View>,
    suns: Vec<Sun>,
    area_lights: Vec<Area>,
    environment: Environment,
}

/// What runs through the patch of each loop.
#[derive(Debug, Serialize)]
struct Yarn {
    /// Of loops that have none of their own.
    kind: String,
    /// Diameter of the strand, mm.
    diameter: f64,
    /// Width, length and thickness of the loop that the strand is drawn in, mm; each loop stretches it to its own.
    reference_size: [f64; 3],
    /// How the layers of a volume blend: `linear` or `nearest`.
    interpolation: String,
    /// Densities are multiplied by smoothstep(v/root_blend), v the share of the way from the root to the top.
    root_blend: f64,
}

/// The ground weave (the paper's §4.1): radii and crimp in mm.
#[derive(Debug, Serialize)]
struct Ground {
    visible: bool,
    height: String,
    warp_radius: f64,
    weft_radius: f64,
    crimp: f64,
    /// Share of light that one scattering gives back.
    albedo: [f64; 3],
}

#[derive(Debug, Serialize)]
struct View {
    name: String,
    /// Position, mm.
    eye: [f64; 3],
    /// Unit vectors.
    right: [f64; 3],
    up: [f64; 3],
    forward: [f64; 3],
    /// Vertical angle of view, degrees; none for orthographic cameras.
    fov: Option<f64>,
    /// Height of the picture, mm; none for perspective cameras.
    orthographic_height: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Sun {
    /// Unit vector towards its centre.
    direction: [f64; 3],
    /// On a plane that faces it.
    irradiance: [f64; 3],
    /// Degrees.
    angular_diameter: f64,
}

/// A rectangle that shines on one side.
#[derive(Debug, Serialize)]
struct Area {
    /// Its middle, mm.
    centre: [f64; 3],
    /// From there to the middles of two neighbouring sides, mm.
    half_sides: [[f64; 3]; 2],
    /// Unit vector to where it shines.
    facing: [f64; 3],
    radiance: [f64; 3],
}

#[derive(Debug, Serialize)]
struct Environment {
    kind: String,
    /// Of the constant environment; what multiplies the others.
    radiance: [f64; 3],
}

impl Surroundings {
    /// Those of a design and its scene.
    pub fn new(design: &Design, scene: &Scene) -> Self {
        let (skeleton, lights) = (&scene.skeleton, &scene.lights);
        Self {
            yarn: Yarn {
                kind: design.pile.kind.name(),
                diameter: design.pile.yarn_diameter,
                reference_size: scene.volumes.reference_size_mm.map(f64::from),
                interpolation: scene.volumes.interpolation.name(),
                root_blend: f64::from(scene.volumes.root_blend),
            },
            ground: Ground {
                visible: skeleton.visible,
                height: skeleton.height.name(),
                warp_radius: f64::from(skeleton.warp_radius_mm),
                weft_radius: f64::from(skeleton.weft_radius_mm),
                crimp: f64::from(skeleton.crimp_mm),
                albedo: skeleton.albedo.map(f64::from),
            },
            cameras: design
                .view
                .cameras
                .iter()
                .map(|camera| View::new(&camera.name, &Camera::from_design(camera)))
                .collect(),
            suns: lights
                .suns
                .iter()
                .map(|sun| Sun {
                    direction: sun.direction,
                    irradiance: sun.irradiance,
                    angular_diameter: 2.0 * sun.angular_radius.to_degrees(),
                })
                .collect(),
            area_lights: lights.areas.iter().map(Area::new).collect(),
            environment: Environment {
                kind: design.light.environment.kind.name(),
                radiance: lights.environment,
            },
        }
    }
}

impl Area {
    fn new(light: &AreaLight) -> Self {
        let [x, y] = light.half_sides.map(DVec3::from_array);
        let area = 4.0 * x.length() * y.length();
        Self {
            centre: light.centre,
            half_sides: light.half_sides,
            facing: light.facing,
            radiance: light.intensity.map(|c| c / area),
        }
    }
}

impl View {
    fn new(name: &str, camera: &Camera) -> Self {
        let (fov, orthographic_height) = match camera.projection {
            Projection::Perspective { fov } => (Some(fov.to_degrees()), None),
            Projection::Orthographic { height_mm } => (None, Some(height_mm)),
        };
        Self {
            name: name.to_owned(),
            eye: camera.eye.into(),
            right: camera.right.into(),
            up: camera.up.into(),
            forward: camera.forward.into(),
            fov,
            orthographic_height,
        }
    }
}
