//! The cloths that a new design can begin as: from size, weight or pile height, ends and picks to a design whose yarn,
//! density, irregularity and view fit each other.

use renderer_core::design::{
    Back, CameraDesign, Colour, Design, Length, Pattern, Phase, Pile, PileKind, Sheared, Sheet,
    SkeletonDesign, Turbulence, View,
};

/// A cloth by its use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClothKind {
    /// A bath towel.
    Towel,
    /// A hand towel.
    HandTowel,
    /// A beach towel, its face sheared to velour.
    BeachTowel,
    /// A bath mat.
    BathMat,
    /// A cut-pile carpet.
    Carpet,
    /// A soft throw with pile on both faces.
    Throw,
    /// Nothing but the program's plain white cloth.
    Blank,
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloth {
    /// Its use.
    pub kind: ClothKind,
    /// Width and length, mm.
    pub size_mm: [f64; 2],
    /// Weight of terry, g/m².
    pub weight: f64,
    /// Pile height of what is not sold by weight, mm.
    pub pile_mm: f64,
    /// Ends and picks a centimetre, as the program counts them: columns and rows of the weave.
    pub per_cm: [f64; 2],
    /// What stands on the reverse side.
    pub back: Back,
}

/// Ends and picks a centimetre of the terry that the constants below are of.
const TERRY: [f64; 2] = [13.3, 14.8];
/// Ends and picks a centimetre of the cut pile that the constants below are of.
const CUT: f64 = 2.5;
/// Crimp of ground ends.
const CRIMP: f64 = 0.08;
/// Ground warp and weft, tex: two-fold 25, and 34.
const GROUND_TEX: [f64; 2] = [50.0, 34.0];
/// Of pile yarn that a drawn loop stands for, tex. Calibrated by a published towel: ground ends 11.9/cm, 657 500 loops
/// of 7.8 mm of 60 tex on a square metre weigh 307 g; as drawn there are three times as many loops.
const LOOP_TEX: f64 = 20.0;
/// How much thicker the pile yarn of a bath mat is.
const MAT_TEX: f64 = 1.8;
/// Shortest and longest loops that terry is made with, mm.
const TERRY_PILE: [f64; 2] = [1.2, 9.0];
/// Angle of view of the cameras, degrees.
const FOV: f64 = 26.0;

impl ClothKind {
    /// All of them, in the order of the list.
    pub const ALL: [Self; 7] = [
        Self::Towel,
        Self::HandTowel,
        Self::BeachTowel,
        Self::BathMat,
        Self::Carpet,
        Self::Throw,
        Self::Blank,
    ];

    /// What the list calls it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Towel => "Bath towel",
            Self::HandTowel => "Hand towel",
            Self::BeachTowel => "Beach towel",
            Self::BathMat => "Bath mat",
            Self::Carpet => "Carpet",
            Self::Throw => "Throw",
            Self::Blank => "Blank",
        }
    }

    /// What it is.
    pub fn what(self) -> &'static str {
        match self {
            Self::Towel => "Terry with loops on both faces.",
            Self::HandTowel => "A smaller, denser sister of the bath towel.",
            Self::BeachTowel => {
                "Large and light, its face sheared to velour for a print or a chart."
            }
            Self::BathMat => "Heavy terry of thick yarn.",
            Self::Carpet => "Cut pile on one face.",
            Self::Throw => "Soft cut pile on both faces.",
            Self::Blank => "The plain white cloth that the program starts with.",
        }
    }

    /// Whether it is terry, which is sold by weight.
    pub fn is_terry(self) -> bool {
        matches!(
            self,
            Self::Towel | Self::HandTowel | Self::BeachTowel | Self::BathMat
        )
    }

    /// Fewest and most ends and picks a centimetre that it is made with here.
    pub fn densities(self) -> [f64; 2] {
        if self.is_terry() || self == Self::Blank {
            [5.0, 40.0]
        } else {
            [1.0, 15.0]
        }
    }

    /// The usual cloth of this kind.
    pub fn usual(self) -> Cloth {
        let (size_cm, weight, pile_mm, per_cm, back) = match self {
            Self::Towel => ([70.0, 140.0], 450.0, 3.0, TERRY, Back::Mirror),
            Self::HandTowel => ([50.0, 100.0], 450.0, 3.0, TERRY, Back::Mirror),
            Self::BeachTowel => ([90.0, 180.0], 380.0, 3.0, [12.0, 13.0], Back::Mirror),
            Self::BathMat => ([50.0, 80.0], 900.0, 5.0, [10.0, 11.0], Back::Mirror),
            Self::Carpet => ([200.0, 300.0], 450.0, 11.0, [CUT; 2], Back::None),
            Self::Throw => ([130.0, 170.0], 450.0, 9.0, [4.0, 4.0], Back::Mirror),
            Self::Blank => ([9.0, 9.5], 450.0, 2.8, TERRY, Back::Mirror),
        };
        Cloth {
            kind: self,
            size_mm: size_cm.map(|cm| 10.0 * cm),
            weight,
            pile_mm,
            per_cm,
            back,
        }
    }
}

impl Cloth {
    /// The design.
    pub fn design(&self) -> Design {
        let mut design = Design {
            sheet: self.sheet(),
            ..Design::default()
        };
        design.weave.back = self.back;
        match self.kind {
            ClothKind::Blank => return design,
            kind if kind.is_terry() => self.make_terry(&mut design),
            _ => self.make_cut(&mut design),
        }
        design.view = self.view();
        design
    }

    fn sheet(&self) -> Sheet {
        let fields = Sheet::FIELDS;
        let yarns = |axis: usize, most: f64| {
            let yarns = (self.size_mm[axis] / 10.0 * self.per_cm[axis]).round();
            yarns.clamp(1.0, most) as u32
        };
        Sheet {
            warps: yarns(0, fields.warps.max),
            wefts: yarns(1, fields.wefts.max),
            warps_per_cm: self.per_cm[0],
            wefts_per_cm: self.per_cm[1],
        }
    }

    /// How much larger everything of a loop is than in cloth as dense as the constants are of.
    fn scale(&self) -> f64 {
        let usual = match self.kind.is_terry() {
            true => TERRY[0] * TERRY[1],
            false => CUT * CUT,
        };
        (usual / (self.per_cm[0] * self.per_cm[1])).sqrt()
    }

    /// Length of loops that gives the weight, mm: what the ground leaves of it is pile yarn, of which a loop takes
    /// 2(L − s/2) + πs/2, s the distance of its legs, and what lies bound in a pick.
    pub fn loop_mm(&self) -> f64 {
        let [ends, picks] = self.per_cm.map(|per_cm| per_cm * 100.0);
        let ground = (ends * (1.0 + CRIMP) * GROUND_TEX[0] + picks * GROUND_TEX[1]) / 1000.0;
        let faces = if self.back == Back::None { 1.0 } else { 2.0 };
        // Every second crossing of a face has a loop; finer cloth has finer yarn.
        let loops = faces * ends * picks / 2.0;
        let scale = self.scale();
        let thicker = if self.kind == ClothKind::BathMat {
            MAT_TEX
        } else {
            1.0
        };
        let tex = LOOP_TEX * thicker * scale * scale;
        let yarn_mm = 1000.0 * (self.weight - ground) * 1000.0 / (loops * tex);
        let pile = terry_pile(scale);
        let legs = pile.base_width - pile.yarn_diameter;
        let bound = 10.0 / self.per_cm[1] * (1.0 + CRIMP);
        let arch = std::f64::consts::FRAC_PI_2 * legs;
        let length = 0.5 * (yarn_mm - bound - arch + legs);
        let [shortest, longest] = TERRY_PILE;
        (length.clamp(shortest, longest) * 10.0).round() / 10.0
    }

    /// The highest pile of cloth so dense, mm: a loop reaches at most [`Sheet::MAX_REACH_CELLS`] crossings, its width
    /// and its irregularity included.
    pub fn highest_mm(&self) -> f64 {
        let pitch = 10.0 / self.per_cm[0].max(self.per_cm[1]);
        (0.75 * Sheet::MAX_REACH_CELLS * pitch).floor()
    }

    fn make_terry(&self, design: &mut Design) {
        let scale = self.scale();
        design.length = Length {
            value: self.loop_mm(),
            ..Length::default()
        };
        design.pile = terry_pile(scale);
        design.turbulence = turbulence(0.25 / scale, 2);
        design.skeleton = ground(scale, Colour([251, 250, 246]));
        if self.kind == ClothKind::BeachTowel {
            // Velour: a fifth of the loops is cut off, and their tops open.
            design.finish.sheared = Sheared::Front;
            design.finish.shear_height = (8.0 * design.length.value).round() / 10.0;
        }
    }

    fn make_cut(&self, design: &mut Design) {
        let (scale, length) = (self.scale(), self.pile_mm.min(self.highest_mm()));
        design.weave.pattern = Pattern::filled(1, 1, 7);
        design.length = Length {
            value: length,
            ..Length::default()
        };
        let defaults = Pile::default();
        design.pile = Pile {
            kind: PileKind::Cut,
            base_width: short(6.0 * scale),
            top_width: short(6.6 * scale),
            thickness: short(6.4 * scale),
            yarn_diameter: short(4.8 * scale),
            fibres: 160,
            hairiness: 0.25,
            density: short(2.5 / scale),
            lean_y: 12.0,
            tilt: if self.kind == ClothKind::Throw {
                24.0
            } else {
                12.0
            },
            twist: 120.0,
            stretch: 0.05,
            jitter: 9.0,
            twist_jitter: 60.0,
            length_jitter: 0.05,
            max_length: defaults.max_length.max(2.0 * length).min(100.0),
            phase: Phase::KajiyaKay,
            specular: 0.3,
            exponent: 8.0,
            ..defaults
        };
        design.turbulence = turbulence(0.03 / scale, 3);
        let colour = match self.kind {
            ClothKind::Carpet => [0x8d, 0x7a, 0x68],
            _ => [0xb4, 0xc0, 0xc6],
        };
        design.chart.colour = Colour(colour);
        let darker = colour.map(|value| (f64::from(value) * 0.76) as u8);
        design.skeleton = SkeletonDesign {
            warp_radius: short(1.6 * scale),
            weft_radius: short(1.6 * scale),
            crimp: short(0.6 * scale),
            colour: Colour(darker),
            ..SkeletonDesign::default()
        };
    }

    /// The whole cloth, and some of it from near.
    fn view(&self) -> View {
        let [width, length] = self.size_mm;
        let half = 0.5 * length.max(width / 1.3);
        let pitch = 10.0 / self.per_cm[0];
        let camera = |name: &str, elevation: f64, distance: f64| CameraDesign {
            name: name.into(),
            azimuth: -90.0,
            elevation,
            distance: distance.round().max(1.0),
            fov: FOV,
            ..CameraDesign::default()
        };
        View {
            cameras: vec![
                camera("whole", 62.0, 1.2 * half / (0.5 * FOV).to_radians().tan()),
                camera("near", 52.0, 150.0 * pitch),
                camera("loops", 40.0, 55.0 * pitch),
            ],
            ..View::default()
        }
    }
}

/// To three digits, as one would type it.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Terry's loops, so much larger than those of the usual towel.
fn terry_pile(scale: f64) -> Pile {
    let defaults = Pile::default();
    Pile {
        base_width: short(defaults.base_width * scale),
        top_width: short(defaults.top_width * scale),
        thickness: short(defaults.thickness * scale),
        yarn_diameter: short(defaults.yarn_diameter * scale),
        twist_per_cm: short(defaults.twist_per_cm / scale),
        hairiness: 0.35,
        density: short(6.5 / scale),
        ..defaults
    }
}

fn turbulence(frequency: f64, octaves: u32) -> Turbulence {
    Turbulence {
        frequency: short(frequency),
        octaves,
        ..Turbulence::default()
    }
}

/// Ground yarns, so much larger than those of the usual towel.
fn ground(scale: f64, colour: Colour) -> SkeletonDesign {
    let defaults = SkeletonDesign::default();
    SkeletonDesign {
        warp_radius: short(defaults.warp_radius * scale),
        weft_radius: short(defaults.weft_radius * scale),
        crimp: short(defaults.crimp * scale),
        colour,
        ..defaults
    }
}
