//! What is printed as it is: templates, completions, the manual.

use clap::CommandFactory;
use clap_mangen::Man;
use wirework::Fault;
use wirework::preset::template;

use crate::args::{Cli, Completions, New};
use crate::console::print;
use crate::exit::Failure;

pub(crate) fn new(args: &New) -> Result<(), Failure> {
    let text = template(&args.effect).map_err(|error| Failure::new(Fault::Request, error.to_string()))?;
    print(text.as_bytes())
}

pub(crate) fn completions(args: &Completions) -> Result<(), Failure> {
    let mut out = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "wirework", &mut out);
    print(&out)
}

/// One page: the command, then each of its commands.
pub(crate) fn man() -> Result<(), Failure> {
    let mut out = Vec::new();
    let mut command = Cli::command();
    command.build();
    let rendered = Man::new(command.clone()).render(&mut out).and_then(|()| {
        let commands = command.get_subcommands().filter(|command| command.get_name() != "help");
        commands.into_iter().try_for_each(|command| {
            let man = Man::new(command.clone());
            man.render_name_section(&mut out)?;
            man.render_synopsis_section(&mut out)?;
            man.render_options_section(&mut out)?;
            if command.get_after_help().is_some() { man.render_extra_section(&mut out) } else { Ok(()) }
        })
    });
    rendered.map_err(|error| Failure::work(format!("the manual cannot be made: {error}")))?;
    print(&out)
}
