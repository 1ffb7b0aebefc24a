//! Colour, variant and material of every loop (MODEL.md §6).

use rayon::prelude::*;

use super::albedo::{AlbedoTable, Dye, wet_albedo_from_reflectance};
use super::chart::ChartOnSheet;
use super::finish::{is_shorn, shear_mm, shorn, wet_pile, wet_reflectance};
use super::frames::loop_hash;
use super::length::{ColourCache, LengthRule};
use super::lod::LodRegion;
use super::skeleton::Face;
use super::{Cancel, LoopLook, Loops, Material, PileOptics, PlantedLoop, SheetGeometry};
use crate::design::{Colour, Design, Phase, Pile, PileKind, Sheared};
use crate::sampling::hash_with;

/// The materials of a design, and which of them each row of its length table uses.
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    /// What volumes are drawn of, each with the diameter of its yarn, mm.
    pub(super) yarns: Vec<(PileKind, f64)>,
    of_row: Vec<u8>,
    /// What becomes of each material where it is shorn.
    shorn: Vec<u8>,
}

impl Materials {
    pub(super) fn new(design: &Design) -> Self {
        let pile = &design.pile;
        let mut materials = Self {
            list: Vec::new(),
            yarns: Vec::new(),
            of_row: Vec::new(),
            shorn: Vec::new(),
        };
        let wetness = design.finish.wetness;
        materials.index_of(&wet_pile(pile, wetness));
        let rows = design.length.rows().iter();
        materials.of_row = rows
            .map(|row| materials.index_of(&wet_pile(&row.of_pile(pile), wetness)))
            .collect();
        if design.finish.sheared != Sheared::None {
            for index in 0..materials.list.len() {
                let material = materials.list[index];
                let (kind, diameter) = materials.yarns[material.kind as usize];
                let kind = index_or_push(&mut materials.yarns, (shorn(kind), diameter)) as u32;
                let shorn = index_or_push(&mut materials.list, Material { kind, ..material });
                materials.shorn.push(shorn as u8);
            }
        }
        materials
    }

    /// The material of a pile, which is added if it is new.
    fn index_of(&mut self, pile: &Pile) -> u8 {
        let yarn = (pile.kind, pile.yarn_diameter);
        let material = Material {
            density_per_mm: pile.density as f32,
            kind: index_or_push(&mut self.yarns, yarn) as u32,
            phase: pile.phase,
            transmission: pile.transmission as f32,
            specular: pile.specular as f32,
            exponent: pile.exponent as f32,
        };
        index_or_push(&mut self.list, material) as u8
    }
}

/// Where a value is in a list, to which it is added if it is new.
fn index_or_push<T: PartialEq>(list: &mut Vec<T>, value: T) -> usize {
    list.iter()
        .position(|known| *known == value)
        .unwrap_or_else(|| {
            list.push(value);
            list.len() - 1
        })
}

impl PileOptics {
    /// How the pile of a design scatters.
    pub(super) fn new(materials: &Materials) -> Self {
        Self {
            materials: materials.list.clone(),
        }
    }

    /// The phase function that all materials share, if they do.
    pub fn shared_phase(&self) -> Option<Phase> {
        let phase = self.materials.first()?.phase;
        let mut materials = self.materials.iter();
        materials.all(|other| other.phase == phase).then_some(phase)
    }

    /// Whether any material has this phase function.
    pub fn has(&self, phase: Phase) -> bool {
        self.materials
            .iter()
            .any(|material| material.phase == phase)
    }
}

/// Looks of all loops, in the order of their shapes; not all of them if `cancel` says so afterwards.
pub(super) fn looks(
    design: &Design,
    sheet: &SheetGeometry,
    loops: &Loops,
    materials: &Materials,
    cancel: &Cancel<'_>,
) -> Vec<LoopLook> {
    let dyer = Dyer::new(design, materials);
    let painter = Painter::new(design, sheet, loops, materials);
    let linear_of = |colour| Colour(colour).linear();
    let dyed_of = |colour| dyer.dyed(colour, linear_of(colour));
    let rows: Vec<Vec<LoopLook>> = (0..loops.sheet_block_rows(sheet))
        .into_par_iter()
        .map_init(
            || (ColourCache::new(dyed_of), ColourCache::new(linear_of)),
            |(dyed, linear), row| {
                if cancel.is_cancelled() {
                    return Vec::new();
                }
                let planted = loops.planted_in_block_row(sheet, row);
                let looks = planted.map(|planted| {
                    let colour = painter.colour(&planted);
                    let mean = painter.mean_colour(&planted, colour, |colour| linear.get(colour));
                    let (albedo, material) = match mean {
                        Some(mean) => dyer.dyed(colour, mean),
                        None => dyed.get(colour),
                    };
                    painter.look(&planted, albedo, material)
                });
                looks.collect()
            },
        )
        .collect();
    rows.concat()
}

/// Gives a loop of some colour its albedo and material.
struct Dyer<'a> {
    design: &'a Design,
    materials: &'a Materials,
    rule: LengthRule,
    /// For each material.
    tables: Vec<AlbedoTable>,
}

impl<'a> Dyer<'a> {
    fn new(design: &'a Design, materials: &'a Materials) -> Self {
        let ground = design.skeleton.colour.linear();
        let ground = ground.map(|ground| wet_reflectance(ground, design.finish.wetness));
        let table = |material: &Material| {
            AlbedoTable::new(&Dye {
                phase: material.phase,
                transmission: f64::from(material.transmission),
                ground,
                bounces: design.quality.bounces,
                max_albedo: design.pile.max_albedo,
            })
        };
        Self {
            design,
            materials,
            rule: LengthRule::new(&design.length),
            tables: materials.list.iter().map(table).collect(),
        }
    }

    /// Albedo, in 65535ths, and material of a loop that has the length, the pile and so on of one colour, and looks
    /// like some linear light.
    fn dyed(&self, colour: [u8; 3], linear: [f64; 3]) -> ([u16; 3], u8) {
        let row = self.rule.row(colour);
        let scale = row.map_or(1.0, |row| self.design.length.table[row].albedo_scale);
        let material = row.map_or(0, |row| self.materials.of_row[row]);
        let table = &self.tables[usize::from(material)];
        let albedo = wet_albedo_from_reflectance(linear, table, self.design.finish.wetness);
        let stored = albedo.map(|a| ((a * scale).clamp(0.0, 1.0) * 65535.0).round() as u16);
        (stored, material)
    }
}

/// Knows of each planted loop what the chart, the shears and chance make of its look.
struct Painter<'a> {
    sheet: &'a SheetGeometry,
    loops: &'a Loops,
    materials: &'a Materials,
    chart: ChartOnSheet<'a>,
    /// The region whose cells stand for several of a chart of several colours.
    mixing: Option<LodRegion>,
    /// Height at which the loops of the front and of the back are shorn, mm.
    shears_mm: [Option<f64>; 2],
    seed: u32,
    variants: u32,
}

impl<'a> Painter<'a> {
    fn new(
        design: &'a Design,
        sheet: &'a SheetGeometry,
        loops: &'a Loops,
        materials: &'a Materials,
    ) -> Self {
        let chart = ChartOnSheet::new(&design.chart, &design.weave, sheet.whole_cells());
        let mixing = sheet.region.filter(|region| region.lod > 0);
        Self {
            sheet,
            loops,
            materials,
            mixing: mixing.filter(|_| !chart.is_uniform()),
            chart,
            shears_mm: [Face::Front, Face::Back].map(|face| shear_mm(&design.finish, face)),
            seed: design.turbulence.seed,
            variants: design.pile.variants,
        }
    }

    /// The cell of the whole cloth that a loop is the copy of.
    fn original(&self, planted: &PlantedLoop) -> [usize; 2] {
        let [i, j] = planted.cell.map(|index| index as usize);
        self.sheet.original(i, j)
    }

    /// A loop's own colour.
    fn colour(&self, planted: &PlantedLoop) -> [u8; 3] {
        let [i, j] = self.original(planted);
        // A loop stands only where the chart has a colour.
        self.chart.colour(i, j).unwrap_or_default()
    }

    /// The mean of the colours that a loop's cell stands for, linear; `None` if all are its `own`. A loop that had one
    /// of them by chance would have the right mean as well, but what a chart draws would go down in noise where loops
    /// are larger than it.
    fn mean_colour(
        &self,
        planted: &PlantedLoop,
        own: [u8; 3],
        mut linear: impl FnMut([u8; 3]) -> [f64; 3],
    ) -> Option<[f64; 3]> {
        let [i, j] = planted.cell.map(|index| index as usize);
        let (mut sum, mut count, mut differ) = ([0.0; 3], 0.0, false);
        for [i, j] in self.mixing?.spread_originals(i, j) {
            let Some(colour) = self.chart.colour(i, j) else {
                continue;
            };
            differ |= colour != own;
            let linear = linear(colour);
            sum = [0, 1, 2].map(|channel| sum[channel] + linear[channel]);
            count += 1.0;
        }
        differ.then(|| sum.map(|sum| sum / count))
    }

    /// The look of a loop of some material before the shears.
    fn look(&self, planted: &PlantedLoop, albedo: [u16; 3], material: u8) -> LoopLook {
        let [i, j] = self.original(planted);
        let hash = loop_hash(self.seed, i as u32, j as u32, planted.face);
        LoopLook {
            albedo,
            variant: (hash_with(hash, 4) % self.variants) as u8,
            material: if self.is_shorn(planted) {
                self.materials.shorn[usize::from(material)]
            } else {
                material
            },
        }
    }

    fn is_shorn(&self, planted: &PlantedLoop) -> bool {
        let shear_mm = self.shears_mm[usize::from(planted.face == Face::Back)];
        shear_mm.is_some_and(|shear_mm| {
            let patch = self.loops.patch(planted.index as usize);
            is_shorn(&patch, planted.face, shear_mm, self.loops.length_unit_mm)
        })
    }
}
