//! What a table of settings is: one row a setting, from which come the struct with its defaults and setters,
//! the check of its numbers, the keys of scene files, the flags of the program and their documentation.
//!
//! A table is written by `settings!`; `RenderSettings` and `Phong` are the two that there are.

use thiserror::Error;

use crate::{Interval, KernelName, NotAChoice, OutOfRange};

/// A struct whose fields are rows of a table.
pub trait Settings: Clone + Default + 'static {
    /// One row a field, in the order in which people read them.
    const ROWS: &'static [Setting<Self>];

    /// Compares every number with what its row permits.
    ///
    /// # Errors
    /// The first number that lies outside.
    fn check_ranges(&self) -> Result<(), OutOfRange> {
        Self::ROWS.iter().try_for_each(|row| row.check_range(self))
    }
}

/// One field of the struct `S`.
#[derive(Debug)]
#[non_exhaustive]
pub struct Setting<S> {
    /// Its name: of the field, the scene file's key, and with dashes, of the flag.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub help: &'static str,
    /// Its type, and how it is read and written.
    pub field: Field<S>,
}

/// What kind of value a setting of `S` has, and how it is read and written.
#[derive(Debug)]
#[expect(clippy::exhaustive_enums, reason = "files and flags have to know each")]
pub enum Field<S> {
    /// One of a closed set of names.
    Choice {
        /// All of them.
        names: &'static [&'static str],
        /// The name of what is chosen.
        get: fn(&S) -> &'static str,
        /// Chooses by name.
        set: fn(&mut S, &str) -> Result<(), NotAChoice>,
    },
    /// The name of a kernel.
    Kernel(Access<S, KernelName>),
    /// A number.
    Number {
        /// What it counts or measures, in a word.
        unit: &'static str,
        /// What it may be.
        range: Interval,
        /// How to get at it.
        access: Access<S, f64>,
    },
    /// A whole number.
    Count {
        /// What it may be.
        range: Interval,
        /// How to get at it.
        access: Access<S, u32>,
    },
    /// Yes or no.
    Switch(Access<S, bool>),
}

/// How a value of type `T` in an `S` is read and written.
#[derive(Debug)]
#[expect(clippy::exhaustive_structs, reason = "a setting is read and written")]
pub struct Access<S, T> {
    /// Reads it.
    pub get: fn(&S) -> T,
    /// Writes it, unchecked.
    pub set: fn(&mut S, T),
}

/// A text that is no value of its setting.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum NotAValue {
    /// It is none of the setting's names.
    #[error("{0}: {1}")]
    Choice(&'static str, NotAChoice),
    /// It is not what the setting counts in.
    #[error("{name} is {expected}, not {text:?}")]
    Other {
        /// Which setting.
        name: &'static str,
        /// What it is.
        expected: &'static str,
        /// What was given.
        text: String,
    },
}

impl<S> Setting<S> {
    fn check_range(&self, settings: &S) -> Result<(), OutOfRange> {
        let (range, value) = match &self.field {
            Field::Number { range, access, .. } => (*range, (access.get)(settings)),
            Field::Count { range, access } => (*range, f64::from((access.get)(settings))),
            Field::Choice { .. } | Field::Kernel(_) | Field::Switch(_) => {
                return Ok(());
            }
        };
        let error = OutOfRange { name: self.name, range, value };
        if range.contains(value) { Ok(()) } else { Err(error) }
    }

    /// Writes what a flag says; ranges and names of kernels are not checked.
    ///
    /// # Errors
    /// If the text is no value of the setting's type.
    pub fn read(&self, settings: &mut S, text: &str) -> Result<(), NotAValue> {
        let other = |expected: &'static str| NotAValue::Other {
            name: self.name,
            expected,
            text: text.to_owned(),
        };
        match &self.field {
            Field::Choice { set, .. } => {
                set(settings, text).map_err(|error| NotAValue::Choice(self.name, error))?;
            }
            Field::Kernel(access) => (access.set)(settings, KernelName::from(text)),
            Field::Number { access, .. } => {
                let number = text.parse().map_err(|_| other("a number"))?;
                (access.set)(settings, number);
            }
            Field::Count { access, .. } => {
                let count = text.parse().map_err(|_| other("a whole number"))?;
                (access.set)(settings, count);
            }
            Field::Switch(access) => {
                let is_on = text.parse().map_err(|_| other("true or false"))?;
                (access.set)(settings, is_on);
            }
        }
        Ok(())
    }

    /// What the setting is in `settings`, as a flag takes it.
    pub fn text(&self, settings: &S) -> String {
        match &self.field {
            Field::Choice { get, .. } => get(settings).to_owned(),
            Field::Kernel(access) => (access.get)(settings).0.into_owned(),
            Field::Number { access, .. } => format!("{:?}", (access.get)(settings)),
            Field::Count { access, .. } => (access.get)(settings).to_string(),
            Field::Switch(access) => (access.get)(settings).to_string(),
        }
    }
}

/// Makes a struct of settings from its table.
///
/// A row is a doc comment, whose first line is the help of the flag and the comment in the example of
/// a scene file; name and type; default; and the kind of field with what that takes, an arm of `field!`.
macro_rules! settings {
    (
        $(#[$attribute:meta])*
        pub struct $table:ident {$(
            #[doc = $help:literal]
            $(#[doc = $more:literal])*
            $name:ident: $ty:ty = $default:expr, $kind:ident $(($($argument:expr),*))?;
        )*}
    ) => {
        $(#[$attribute])*
        pub struct $table {$(
            #[doc = $help]
            $(#[doc = $more])*
            pub $name: $ty,
        )*}

        impl Default for $table {
            fn default() -> Self {
                Self { $($name: $default),* }
            }
        }

        impl $table {$(
            #[doc = concat!("The same with another `", stringify!($name), "`; not checked.")]
            #[must_use]
            pub fn $name(mut self, $name: $ty) -> Self {
                self.$name = $name;
                self
            }
        )*}

        impl $crate::Settings for $table {
            const ROWS: &'static [$crate::Setting<Self>] = &[$($crate::Setting {
                name: stringify!($name),
                help: $help.trim_ascii(),
                field: $crate::settings_table::field!($kind $(($($argument),*))?, $name: $ty),
            }),*];
        }
    };
}

/// The [`Field`] of a row, by its kind.
macro_rules! field {
    (choice, $name:ident: $ty:ty) => {
        $crate::Field::Choice {
            names: <$ty>::NAMES,
            get: |settings| settings.$name.name(),
            set: |settings, name| {
                settings.$name = name.parse()?;
                Ok(())
            },
        }
    };
    (kernel, $name:ident: $ty:ty) => {
        $crate::Field::Kernel($crate::Access {
            get: |settings| settings.$name.clone(),
            set: |settings, name| settings.$name = name,
        })
    };
    (number($unit:expr, $range:expr), $name:ident: $ty:ty) => {
        $crate::Field::Number {
            unit: $unit,
            range: $range,
            access: $crate::settings_table::access!($name),
        }
    };
    (count($range:expr), $name:ident: $ty:ty) => {
        $crate::Field::Count { range: $range, access: $crate::settings_table::access!($name) }
    };
    (switch, $name:ident: $ty:ty) => {
        $crate::Field::Switch($crate::settings_table::access!($name))
    };
}

/// The [`Access`] to a field that is copied.
macro_rules! access {
    ($name:ident) => {
        $crate::Access {
            get: |settings| settings.$name,
            set: |settings, value| settings.$name = value,
        }
    };
}

pub(crate) use {access, field, settings};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lookup, Phong, RenderSettings};

    #[test]
    fn settings_rows_read_and_write_their_field() {
        let row = |name: &str| RenderSettings::ROWS.iter().find(|row| row.name == name).unwrap();
        let mut settings = RenderSettings::default();
        let Field::Number { access, .. } = &row("slab_width").field else { panic!("a number") };
        (access.set)(&mut settings, 0.25);
        let Field::Choice { set, .. } = &row("lookup").field else { panic!("a choice") };
        set(&mut settings, "nearest").unwrap();
        assert!(set(&mut settings, "farthest").is_err());
        assert_eq!(settings, RenderSettings::default().slab_width(0.25).lookup(Lookup::Nearest));
        assert_eq!(row("slab_width").text(&settings), "0.25");
        assert_eq!(row("kernel").text(&settings), "gaussian");
    }

    #[test]
    fn settings_rows_read_what_they_write() {
        check_reading::<RenderSettings>();
        check_reading::<Phong>();
        let row = |name: &str| RenderSettings::ROWS.iter().find(|row| row.name == name).unwrap();
        let error = |name, text| {
            let error = row(name).read(&mut RenderSettings::default(), text);
            error.unwrap_err().to_string()
        };
        assert_eq!(error("slab_width", "wide"), "slab_width is a number, not \"wide\"");
        assert_eq!(error("sections", "1.5"), "sections is a whole number, not \"1.5\"");
        assert!(error("lookup", "far").starts_with("lookup: \"far\" is not a choice here"));
    }

    fn check_reading<S: Settings + PartialEq + std::fmt::Debug>() {
        for row in S::ROWS {
            let mut settings = S::default();
            row.read(&mut settings, &row.text(&S::default())).unwrap();
            assert_eq!(settings, S::default(), "{}", row.name);
        }
    }

    /// Help is shown as it stands: one sentence.
    #[test]
    fn settings_have_help() {
        let settings = RenderSettings::ROWS.iter().map(|row| (row.name, row.help));
        let phong = Phong::ROWS.iter().map(|row| (row.name, row.help));
        for (name, help) in settings.chain(phong) {
            assert!(help.ends_with('.') && !help.starts_with(' '), "{name}");
        }
    }

    #[test]
    fn settings_have_defaults_in_range() {
        assert_eq!(RenderSettings::default().check_ranges(), Ok(()));
        assert_eq!(Phong::default().check_ranges(), Ok(()));
    }
}
