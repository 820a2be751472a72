//! The `etendue` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    etendue::cli::run()
}
