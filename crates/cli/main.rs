//! The command `wirework`: arguments are parsed and resolved, one function of the library is called, and what came of
//! it is told.

mod apply;
mod args;
mod bake_map;
mod check;
mod console;
mod diagnostics;
mod exit;
mod inspect;
mod limits;
mod presets;
mod render;
mod shell;

use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook};
use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use console::Console;
use exit::Failure;

fn main() -> ExitCode {
    set_hook(Box::new(bug));
    // The hook has said what there is to say.
    catch_unwind(AssertUnwindSafe(start)).unwrap_or(ExitCode::FAILURE)
}

fn start() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version come this way too; nobody is left to hear of a closed pipe.
            drop(error.print());
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    let console = Console::new(cli.talk);
    match run(console, &cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure { code, message }) => {
            if let Some(message) = message {
                console.fail(&message);
            }
            ExitCode::from(code)
        }
    }
}

fn run(console: Console, command: &Command) -> Result<(), Failure> {
    match command {
        Command::Apply(args) => apply::run(console, args),
        Command::Render(args) => render::run(console, args),
        Command::BakeMap(args) => bake_map::run(console, args),
        Command::Check(args) => check::run(console, args),
        Command::New(args) => shell::new(args),
        Command::Inspect(args) => inspect::run(console, args),
        Command::Completions(args) => shell::completions(args),
        Command::Man => shell::man(),
    }
}

/// A panic is a bug; it is told in one line.
fn bug(info: &PanicHookInfo<'_>) {
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
    let place = info.location().map(|place| format!(" at {}:{}", place.file(), place.line()));
    let line = format!("wirework has a bug{}: {text}; please report it", place.unwrap_or_default());
    drop(std::io::Write::write_all(
        &mut std::io::stderr(),
        format!("{}\n", line.replace('\n', " ")).as_bytes(),
    ));
}
