//! Colour, variant and material of every loop (MODEL.md §6).

use rayon::prelude::*;

use super::albedo::{AlbedoTable, Dye, wet_albedo_from_reflectance};
use super::chart::ChartOnSheet;
use super::finish::{is_shorn, shear_mm, shorn, wet_pile, wet_reflectance};
use super::frames::loop_hash;
use super::length::{ColourCache, LengthRule};
use super::skeleton::Face;
use super::{Cancel, Excerpt, LoopLook, Loops, Material, PileOptics, SheetGeometry};
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
    let [warps, wefts] = sheet.whole_cells();
    let chart = ChartOnSheet::new(&design.chart, warps, wefts);
    let rule = LengthRule::new(&design.length);
    let wetness = design.finish.wetness;
    let shears_mm = [Face::Front, Face::Back].map(|face| shear_mm(&design.finish, face));
    let dye = |material: &Material| Dye {
        phase: material.phase,
        transmission: f64::from(material.transmission),
        ground: design
            .skeleton
            .colour
            .linear()
            .map(|ground| wet_reflectance(ground, wetness)),
        bounces: design.quality.bounces,
        max_albedo: design.pile.max_albedo,
    };
    let tables: Vec<AlbedoTable> = materials
        .list
        .iter()
        .map(|material| AlbedoTable::new(&dye(material)))
        .collect();
    // Albedo and material of a loop that has the length, the pile and so on of one colour, and looks like some linear light.
    let dyed = |colour: [u8; 3], linear: [f64; 3]| -> ([u16; 3], u8) {
        let row = rule.row(colour);
        let scale = row.map_or(1.0, |row| design.length.table[row].albedo_scale);
        let material = row.map_or(0, |row| materials.of_row[row]);
        let table = &tables[usize::from(material)];
        let albedo = wet_albedo_from_reflectance(linear, table, wetness);
        let stored = albedo.map(|a| ((a * scale).clamp(0.0, 1.0) * 65535.0).round() as u16);
        (stored, material)
    };
    let of_colour = |colour: [u8; 3]| dyed(colour, Colour(colour).linear());
    let merging = sheet.excerpt.filter(|excerpt| excerpt.halvings > 0);
    let merging = merging.filter(|_| !chart.is_uniform());
    let rows: Vec<Vec<LoopLook>> = (0..loops.sheet_block_rows(sheet))
        .into_par_iter()
        .map_init(
            || {
                let linear = |colour| Colour(colour).linear();
                (ColourCache::new(of_colour), ColourCache::new(linear))
            },
            |(cache, linear), row| {
                if cancel.is_cancelled() {
                    return Vec::new();
                }
                let looks = loops.planted_in_block_row(sheet, row).map(|planted| {
                    let cell = planted.cell.map(|index| index as usize);
                    let [i, j] = sheet.original(cell[0], cell[1]);
                    // A loop stands only where the chart has a colour.
                    let colour = chart.colour(i, j).unwrap_or_default();
                    let mean = merging.and_then(|excerpt| {
                        mean_colour(&excerpt, &chart, cell, colour, |colour| linear.get(colour))
                    });
                    let (albedo, material) = match mean {
                        Some(mean) => dyed(colour, mean),
                        None => cache.get(colour),
                    };
                    let hash = loop_hash(design.turbulence.seed, i as u32, j as u32, planted.face);
                    let is_shorn = |shear_mm| {
                        let patch = loops.patch(planted.index as usize);
                        is_shorn(&patch, planted.face, shear_mm, loops.length_unit_mm)
                    };
                    let material = match shears_mm[usize::from(planted.face == Face::Back)] {
                        Some(shear_mm) if is_shorn(shear_mm) => {
                            materials.shorn[usize::from(material)]
                        }
                        _ => material,
                    };
                    LoopLook {
                        albedo,
                        variant: (hash_with(hash, 4) % design.pile.variants) as u8,
                        material,
                    }
                });
                looks.collect()
            },
        )
        .collect();
    rows.concat()
}

/// The mean of the colours that a cell of halved cloth stands for, linear; `None` if all are `own`. A loop that had one of them
/// by chance would have the right mean as well, but what a chart draws would go down in noise where loops are larger than it.
fn mean_colour(
    excerpt: &Excerpt,
    chart: &ChartOnSheet<'_>,
    [i, j]: [usize; 2],
    own: [u8; 3],
    mut linear: impl FnMut([u8; 3]) -> [f64; 3],
) -> Option<[f64; 3]> {
    let (mut sum, mut count, mut differ) = ([0.0; 3], 0.0, false);
    for [i, j] in excerpt.spread_originals(i, j) {
        let Some(colour) = chart.colour(i, j) else {
            continue;
        };
        differ |= colour != own;
        let linear = linear(colour);
        sum = [0, 1, 2].map(|channel| sum[channel] + linear[channel]);
        count += 1.0;
    }
    differ.then(|| sum.map(|sum| sum / count))
}
