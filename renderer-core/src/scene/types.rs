//! The records a scene is made of.

use std::ops::Deref;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::lod::LodRegion;
use super::{FormMesh, Loops};
use crate::design::{
    EnvironmentImage, Interpolation, Phase, PileKind, SkeletonHeight, SkeletonShading,
};

/// A part of a scene. Equality is identity: an unchanged part is the same `Arc`.
#[derive(Debug)]
pub struct Section<T>(Arc<T>);

impl<T> Section<T> {
    /// A new part, different from all others.
    pub fn new(value: T) -> Self {
        Self(Arc::new(value))
    }
}

impl<T> Clone for Section<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> PartialEq for Section<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T> Deref for Section<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

/// Everything a renderer needs to know about the cloth and its light.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Size of the sheet and of its cells.
    pub sheet: Section<SheetGeometry>,
    /// Shape of every loop, and which loops each cell holds.
    pub loops: Section<Loops>,
    /// Colour, variant and material of every loop, in the order of [`Loops::shapes`].
    pub looks: Section<Vec<LoopLook>>,
    /// Voxels inside the loops.
    pub volumes: Section<Volumes>,
    /// How a point of the pile scatters, and what materials there are.
    pub pile: Section<PileOptics>,
    /// The ground weave.
    pub skeleton: Section<Skeleton>,
    /// How the cloth lies in space; `None` for level cloth, whose sheet space is world space.
    pub form: Section<Option<FormMesh>>,
    /// Lights and background.
    pub lights: Section<Lights>,
}

impl Scene {
    /// Lowest and highest point of loops and ground yarns over the sheet, mm.
    pub fn heights_mm(&self) -> [f64; 2] {
        heights_mm(&self.loops, &self.skeleton)
    }

    /// The world position of a sheet position, mm.
    #[inline(always)]
    pub fn world_of(&self, sheet: DVec3) -> DVec3 {
        (self.form.as_ref()).map_or(sheet, |form| form.world_of(sheet))
    }

    /// The world position of a sheet position, mm, where lights depend on it; without area lights the sheet position
    /// itself.
    #[inline(always)]
    pub fn lit_point(&self, sheet: DVec3) -> DVec3 {
        if self.lights.areas.is_empty() {
            sheet
        } else {
            self.world_of(sheet)
        }
    }

    /// Whether as much of each light reaches every point of both scenes: colours and backgrounds may differ.
    pub fn has_same_shadows(&self, other: &Self) -> bool {
        self.sheet == other.sheet
            && self.loops == other.loops
            && self.volumes == other.volumes
            && self.pile == other.pile
            && self.skeleton == other.skeleton
            && self.form == other.form
            && self.lights == other.lights
    }
}

/// Size of the sheet (MODEL.md §1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetGeometry {
    /// Cells along the weft (x).
    pub warps: u32,
    /// Cells along the warp (y).
    pub wefts: u32,
    /// Size of a cell along x, mm.
    pub pitch_x_mm: f64,
    /// Size of a cell along y, mm.
    pub pitch_y_mm: f64,
    /// Which part of a larger cloth this is; `None` for a whole one.
    pub region: Option<LodRegion>,
}

impl SheetGeometry {
    /// Centre of cell (i, j) in world space, mm; cells outside the sheet continue the grid.
    pub fn cell_centre(&self, i: i64, j: i64) -> [f64; 2] {
        [
            (i as f64 + 0.5 - f64::from(self.warps) / 2.0) * self.pitch_x_mm,
            (j as f64 + 0.5 - f64::from(self.wefts) / 2.0) * self.pitch_y_mm,
        ]
    }
}

/// Colour and kind of one loop. 8 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct LoopLook {
    /// Single-scatter albedo of red, green and blue, 65535 = 1.
    pub albedo: [u16; 3],
    /// Which volume of its kind: below [`Volumes::variants`].
    pub variant: u8,
    /// Index into [`PileOptics::materials`].
    pub material: u8,
}

impl LoopLook {
    /// Single-scatter albedo in [0, 1].
    pub fn albedo(&self) -> [f64; 3] {
        self.albedo.map(|a| f64::from(a) / 65535.0)
    }
}

/// How many loops stand, and how many were changed to keep the geometry sound (MODEL.md §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LoopCounts {
    /// Loops in the scene.
    pub planted: u64,
    /// Loops left out because their patch was degenerate (|b × c| < 10⁻³·w₀·L).
    pub dropped: u64,
    /// Loops whose top width was moved towards the root width to keep the patch convex.
    pub repaired: u64,
    /// Loops whose lean was reduced to keep their top above the sheet.
    pub raised: u64,
    /// Loops shortened to `max_length`.
    pub capped: u64,
}

/// The voxels inside loops (MODEL.md §5): (kind, variant) volumes of `layers` × `resolution`² voxels.
///
/// Voxel (a, b) of layer l of variant v of kind k has index
/// (((k·variants + v)·layers + l)·resolution + b)·resolution + a; a runs along u, b along v.
#[derive(Debug, Clone)]
pub struct Volumes {
    /// Voxels along u and along v.
    pub resolution: u32,
    /// Layers across the thickness.
    pub layers: u32,
    /// Volumes of each kind.
    pub variants: u32,
    /// The kinds of pile present, in volume order.
    pub kinds: Vec<PileKind>,
    /// Blend between layers.
    pub interpolation: Interpolation,
    /// Share of the loop from its root over which density fades in: ρ is multiplied by smoothstep(0, `root_blend`, v).
    pub root_blend: f32,
    /// Density ρ and ρ·shade of each voxel, 255 = 1.
    pub voxels: Vec<[u8; 2]>,
    /// ρ·ttᵀ of each voxel as (xx, yy, zz, xy, xz, yz, 0, 0), 127 = 1, t the fibre's unit tangent in the loop's
    /// reference frame (u, v, w axes in mm at the reference size). Empty unless the phase function needs it.
    pub tangents: Vec<[i8; 8]>,
    /// Size of the reference loop along u, v, w, mm: t in (u, v, w) is t_mm / this.
    pub reference_size_mm: [f32; 3],
}

/// One kind of yarn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Extinction of solid yarn (ρ = 1), 1/mm.
    pub density_per_mm: f32,
    /// Index into [`Volumes::kinds`].
    pub kind: u32,
    /// Phase function.
    pub phase: Phase,
    /// k of `frame_lambert`: share of light let through.
    pub transmission: f32,
    /// s of `kajiya_kay`: share of light in the highlight.
    pub specular: f32,
    /// p of `kajiya_kay`: sharpness of the highlight.
    pub exponent: f32,
}

/// How the pile scatters (MODEL.md §8).
#[derive(Debug, Clone, PartialEq)]
pub struct PileOptics {
    /// Materials that loops refer to; the first is the pile's own. At most 130: of the pile and
    /// 64 rows, each also shorn.
    pub materials: Vec<Material>,
}

/// The ground weave (MODEL.md §7).
#[derive(Debug, Clone, PartialEq)]
pub struct Skeleton {
    /// Radius of the warps, mm.
    pub warp_radius_mm: f32,
    /// Radius of the wefts, mm.
    pub weft_radius_mm: f32,
    /// H: how far yarns rise and sink, mm.
    pub crimp_mm: f32,
    /// How height follows over and under.
    pub height: SkeletonHeight,
    /// How yarns scatter.
    pub shading: SkeletonShading,
    /// Share of light that one scattering gives back, linear.
    pub albedo: [f32; 3],
    /// Share of it in the highlight, for `phong` and `poulin_fournier`.
    pub specular: f32,
    /// Sharpness of the highlight.
    pub exponent: f32,
    /// Distance of neighbouring fibres, in their diameters, for `poulin_fournier`; at least 1.
    pub fibre_spacing: f32,
    /// Whether rays meet it.
    pub visible: bool,
    /// Repeat of the stitch pattern along x and y, cells.
    pub repeat: [u32; 2],
    /// For each cell of the repeat, row by row: whether the warp lies over the weft.
    pub warp_over: Vec<bool>,
}

/// Lowest and highest point of loops and ground yarns over the sheet, mm.
pub(super) fn heights_mm(loops: &Loops, skeleton: &Skeleton) -> [f64; 2] {
    let [mut low, mut high] = loops.z_range_mm.map(f64::from);
    if skeleton.visible {
        let thickest = skeleton.warp_radius_mm.max(skeleton.weft_radius_mm);
        let reach = f64::from(match skeleton.height {
            SkeletonHeight::Winding => thickest + skeleton.crimp_mm,
            SkeletonHeight::Paper => thickest,
        });
        (low, high) = (low.min(-reach), high.max(reach));
    }
    [low, high]
}

/// A sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunLight {
    /// Unit vector towards the sun's centre, world space.
    pub direction: [f64; 3],
    /// Half the apparent diameter, radians.
    pub angular_radius: f64,
    /// Irradiance on a plane that faces the sun, linear RGB.
    pub irradiance: [f64; 3],
}

/// A rectangle that shines on the side that it faces the middle of the cloth with. The whole cloth is on that side, so
/// that nothing behind it is in the way of a ray to it. World space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaLight {
    /// Its middle, mm.
    pub centre: [f64; 3],
    /// From its middle to the middles of two neighbouring sides, mm; perpendicular.
    pub half_sides: [[f64; 3]; 2],
    /// Unit vector from its middle towards the cloth's.
    pub facing: [f64; 3],
    /// Radiance times area, mm²: irradiance far away along `facing` is this over the distance squared. Linear RGB.
    pub intensity: [f64; 3],
}

/// How light from all around varies with direction, as a factor for each channel. World space: +z is the cloth's front
/// normal.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// 1 everywhere.
    Uniform,
    /// With s = z of the unit direction: horizon + (zenith − horizon)·smoothstep(0, 1, s) above,
    /// horizon + (ground − horizon)·smoothstep(0, [`Sky::HAZE`], −s) below. Its slope is continuous.
    Gradient {
        /// Linear RGB at the zenith.
        zenith: [f64; 3],
        /// Linear RGB at the horizon.
        horizon: [f64; 3],
        /// Linear RGB below.
        ground: [f64; 3],
    },
    /// Equirectangular: rows at equal steps of the angle from +z, columns at equal steps of the azimuth, which falls
    /// from left to right (a viewer inside who turns right sees the next column). Bilinear between texel centres,
    /// around the border from column to column, and constant beyond the centres of the first and the last row.
    Image {
        /// The picture.
        image: EnvironmentImage,
        /// Azimuth of the picture's middle, radians.
        middle: f64,
    },
}

impl Sky {
    /// Sine of the depth below the horizon at which the gradient has reached the ground's colour.
    pub const HAZE: f64 = 0.3;
}

/// Lights and background.
#[derive(Debug, Clone, PartialEq)]
pub struct Lights {
    /// Suns, at most 8.
    pub suns: Vec<SunLight>,
    /// Area lights, at most 4.
    pub areas: Vec<AreaLight>,
    /// Radiance of the environment where `sky` is 1, linear RGB.
    pub environment: [f64; 3],
    /// How the environment varies with direction: a factor on its radiance.
    pub sky: Sky,
    /// What the camera sees where there is no cloth, linear RGB; it gives no light.
    pub background: [f64; 3],
}
