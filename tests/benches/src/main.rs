//! The program: parses arguments.

use std::process::ExitCode;

fn main() -> ExitCode {
    towel_benches::command::main()
}
