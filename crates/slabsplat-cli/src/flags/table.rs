//! A flag for every row of a settings table: its name, help, choices and default are the row's.

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};
use slabsplat::{Access, Field, KERNEL_NAMES, KernelName, Setting, Settings};

/// The flags of the table of `S`, as given.
pub(super) struct TableFlags<S: 'static> {
    given: Vec<Given<S>>,
}

/// A flag that was given, ready to be laid over settings.
struct Given<S: 'static> {
    row: &'static Setting<S>,
    set: Set<S>,
}

/// Writes a value that it knows into settings.
type Set<S> = Box<dyn Fn(&mut S) + Send>;

impl<S: Settings> TableFlags<S> {
    /// The settings, with what flags say instead; not checked.
    pub(super) fn lay_over(&self, mut settings: S) -> S {
        for given in &self.given {
            (given.set)(&mut settings);
        }
        settings
    }

    /// The names of the settings that flags give.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.given.iter().map(|given| given.row.name)
    }
}

/// How the flag of a setting is spelt, without its dashes.
pub(super) fn flag_name(setting: &str) -> String {
    setting.replace('_', "-")
}

impl<S: Settings> Args for TableFlags<S> {
    fn augment_args(command: Command) -> Command {
        command.args(S::ROWS.iter().map(flag))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Settings> FromArgMatches for TableFlags<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |row| Some(Given { row, set: set_by(row, matches)? });
        Ok(Self { given: S::ROWS.iter().filter_map(given).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.given.extend(Self::from_arg_matches(matches)?.given);
        Ok(())
    }
}

fn flag<S: Settings>(row: &Setting<S>) -> Arg {
    let default = row.text(&S::default());
    let help = format!("{} [default: {default}]", row.help.trim_end_matches('.'));
    let flag = Arg::new(row.name).long(flag_name(row.name)).help(help);
    match &row.field {
        Field::Choice { names, .. } => {
            let parser = PossibleValuesParser::new(*names);
            flag.value_name(row.name.to_uppercase()).value_parser(parser)
        }
        Field::Kernel(_) => flag.value_name("NAME").value_parser(KERNEL_NAMES.to_vec()),
        Field::Number { unit, .. } => {
            flag.value_name(*unit).value_parser(value_parser!(f64)).allow_hyphen_values(true)
        }
        Field::Count { .. } => flag.value_name("N").value_parser(value_parser!(u32)),
        Field::Switch(_) => flag.value_name("BOOL").value_parser(value_parser!(bool)),
    }
}

/// What writes the value of a row's flag; `None` if it was not given.
fn set_by<S>(row: &'static Setting<S>, matches: &ArgMatches) -> Option<Set<S>> {
    Some(match &row.field {
        Field::Choice { set, .. } => {
            let name = matches.get_one::<String>(row.name)?.clone();
            Box::new(move |settings| set(settings, &name).expect("clap knows the choices"))
        }
        Field::Kernel(access) => {
            let name = matches.get_one::<String>(row.name)?.clone();
            write(access, KernelName(name.into()))
        }
        Field::Number { access, .. } => write(access, *matches.get_one(row.name)?),
        Field::Count { access, .. } => write(access, *matches.get_one(row.name)?),
        Field::Switch(access) => write(access, *matches.get_one(row.name)?),
    })
}

fn write<S, T: Clone + Send + 'static>(access: &'static Access<S, T>, value: T) -> Set<S> {
    Box::new(move |settings| (access.set)(settings, value.clone()))
}
