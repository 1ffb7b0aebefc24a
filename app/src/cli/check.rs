//! `check`: validates presets, bundles and pictures that carry a design, with the images they name, and prints every
//! fault: what it calls sound, `render` makes a picture of.

use std::io::Write;
use std::path::PathBuf;

use renderer_core::design::{Design, Warning};
use renderer_core::geometry::Camera;
use renderer_core::scene::lod::{LodBudget, LodCompiler, LodPlan};
use renderer_core::scene::{Cancel, CompileError};

use super::arguments::{self, BadArgument};
use super::read_design;
use crate::advice::{with_advice_on_cloth, with_advice_on_file};

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    /// Presets, bundles, or pictures that carry their design.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Open images that presets name outside their own folders.
    #[arg(long)]
    allow_outside_images: bool,
}

/// Prints a line for each sound preset, and every fault of the others to stderr.
pub fn run(arguments: &CheckArguments) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    let size = arguments::size(arguments::DEFAULT_SIZE).map_err(BadArgument)?;
    let mut faulty = 0;
    for file in &arguments.files {
        match read_design(file, &[], arguments.allow_outside_images) {
            Ok(opened) => {
                for warning in &opened.warnings {
                    eprintln!("warning: {warning}");
                }
                match cloth(&opened.design, size) {
                    Ok(warnings) => {
                        for warning in warnings {
                            eprintln!("{}: warning: {warning}", file.display());
                        }
                        writeln!(out, "{}: ok", file.display())?;
                    }
                    Err(error) => {
                        eprintln!("{}: {}", file.display(), with_advice_on_cloth(&error));
                        faulty += 1;
                    }
                }
            }
            Err(error) => {
                eprintln!("{}", with_advice_on_file(&error));
                faulty += 1;
            }
        }
    }
    match (faulty, arguments.files.len()) {
        (0, _) => Ok(()),
        (_, 1) => Err(BadArgument("the preset has faults".into()).into()),
        (faulty, all) => Err(BadArgument(format!("{faulty} of {all} presets have faults")).into()),
    }
}

/// Finds out whether the cloth can be made as each camera shows it in a picture of a size, and what is to be known of it.
fn cloth(design: &Design, size: [u32; 2]) -> Result<Vec<Warning>, CompileError> {
    let mut warnings = Vec::new();
    let mut compiler = LodCompiler::default();
    for camera in design.view.cameras.iter().chain(&design.view.current) {
        let camera = Camera::from_design(camera);
        let plan = LodPlan::new(design, &camera, size, LodBudget::FINAL, None);
        let is_whole = plan.regions.is_empty();
        for warning in compiler.check(design, &plan, &Cancel::never())? {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        if is_whole {
            // Whatever sees it.
            break;
        }
    }
    Ok(warnings)
}
