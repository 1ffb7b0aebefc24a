//! The program: parses arguments; no subcommand opens the designer.

use std::process::ExitCode;

fn main() -> ExitCode {
    towel_designer::cli::main()
}
