//! `export loops`: every loop of a design, in mm and world space, and the list of them as JSON with what else a
//! renderer needs to draw the same picture. Bent cloth has its loops where they lie; its ground is given as that of
//! flat cloth.

use std::path::Path;

use glam::DVec3;
use renderer_core::design::{Colour, Design, Phase};
use renderer_core::scene::{self, ChartOnSheet, Face, Material, PlantedLoop, Scene, Volumes};

use super::surroundings::Surroundings;
use super::volume::{kind_names, volume_name};
use crate::files;

/// One loop as other programs see it.
pub struct LoopRecord {
    /// Where it stands.
    pub planted: PlantedLoop,
    /// P0 to P3, mm, world space.
    pub corners: [DVec3; 4],
    /// Unit normal of its patch's middle.
    pub normal: DVec3,
    /// Colour of its chart texel.
    pub colour: Colour,
    /// Length of its axis, mm.
    pub length: f64,
    /// Single-scatter albedo of its fibres, linear.
    pub albedo: [f64; 3],
    /// Which of the volumes of its kind.
    pub variant: u8,
    /// What its yarn is and how that scatters; [`Material::kind`] is an index into [`Volumes::kinds`].
    pub material: Material,
}

/// All loops of a scene, row by row from the near edge.
pub fn records<'s>(
    design: &'s Design,
    scene: &'s Scene,
) -> impl Iterator<Item = LoopRecord> + use<'s> {
    let (sheet, loops) = (&*scene.sheet, &*scene.loops);
    let chart = ChartOnSheet::new(&design.chart, &design.weave, [sheet.warps, sheet.wefts]);
    let planted = (0..sheet.wefts).flat_map(move |j| loops.planted_in_row(sheet, j));
    planted.map(move |planted| {
        let [i, j] = planted.cell;
        let [x, y] = sheet.cell_centre(i64::from(i), i64::from(j));
        let patch = loops.patch(planted.index as usize);
        let look = &scene.looks[planted.index as usize];
        let centre = DVec3::new(x, y, 0.0);
        LoopRecord {
            planted,
            corners: patch
                .corners(loops.base_width_mm)
                .map(|corner| scene.world_of(centre + corner)),
            normal: match &*scene.form {
                Some(form) => form.rotation_at(centre) * patch.normal(loops.base_width_mm),
                None => patch.normal(loops.base_width_mm),
            },
            colour: Colour(chart.colour(i as usize, j as usize).unwrap_or_default()),
            length: DVec3::from_array(patch.axis.map(f64::from)).length(),
            albedo: look.albedo(),
            variant: look.variant,
            material: scene.pile.materials[usize::from(look.material)],
        }
    })
}

/// Writes the list as JSON, a loop a line.
pub fn write(design: &Design, output: &Path) -> anyhow::Result<()> {
    let scene = scene::compile(design)?;
    let surroundings = serde_json::to_value(Surroundings::new(design, &scene))?;
    files::write_atomically_with(output, |file| {
        let sheet = &scene.sheet;
        writeln!(file, "{{")?;
        writeln!(
            file,
            "\"units\": \"mm, world space: x along the weft, y along the warp, z up from the front\","
        )?;
        writeln!(
            file,
            "\"warps\": {}, \"wefts\": {}, \"pitch\": [{}, {}], \"thickness\": {},",
            sheet.warps, sheet.wefts, sheet.pitch_x_mm, sheet.pitch_y_mm, scene.loops.thickness_mm
        )?;
        // A part a line, like the loops.
        for (name, part) in surroundings.as_object().into_iter().flatten() {
            writeln!(file, "\"{name}\": {part},")?;
        }
        write!(file, "\"loops\": [")?;
        let names = kind_names(&scene.volumes);
        for (index, record) in records(design, &scene).enumerate() {
            let separator = if index == 0 { "" } else { "," };
            write!(
                file,
                "{separator}\n{}",
                json(&record, &scene.volumes, &names)
            )?;
        }
        writeln!(file, "\n]\n}}")
    })?;
    Ok(())
}

/// One loop as a line of JSON; `names` are those of the kinds of volumes.
fn json(record: &LoopRecord, volumes: &Volumes, names: &[String]) -> String {
    // Six decimals: nanometres.
    let vector = |v: DVec3| format!("[{:.6},{:.6},{:.6}]", v.x, v.y, v.z);
    let [p0, p1, p2, p3] = record.corners.map(vector);
    let [i, j] = record.planted.cell;
    let face = match record.planted.face {
        Face::Front => "front",
        Face::Back => "back",
    };
    let [r, g, b] = record.albedo;
    let material = &record.material;
    let kind = material.kind as usize;
    let mut line = format!("{{\"cell\":[{i},{j}],\"face\":\"{face}\"");
    line += &format!(",\"p0\":{p0},\"p1\":{p1},\"p2\":{p2},\"p3\":{p3}");
    line += &format!(",\"normal\":{}", vector(record.normal));
    line += &format!(",\"colour\":\"{}\"", String::from(record.colour));
    line += &format!(",\"albedo\":[{r:.5},{g:.5},{b:.5}]");
    line += &format!(",\"length\":{:.6}", record.length);
    line += &format!(",\"kind\":\"{}\"", volumes.kinds[kind].name());
    line += &format!(
        ",\"volume\":\"{}\"",
        volume_name(&names[kind], record.variant.into())
    );
    line += &format!(",\"variant\":{}", record.variant);
    line += &format!(",\"density\":{}", material.density_per_mm);
    line += &format!(",\"phase\":\"{}\"", material.phase.name());
    match material.phase {
        Phase::Isotropic => {}
        Phase::FrameLambert | Phase::GradientLambert => {
            line += &format!(",\"transmission\":{}", material.transmission);
        }
        Phase::KajiyaKay => {
            let Material {
                specular, exponent, ..
            } = material;
            line += &format!(",\"specular\":{specular},\"exponent\":{exponent}");
        }
    }
    line + "}"
}
