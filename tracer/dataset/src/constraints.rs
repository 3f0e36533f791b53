//! The constraints of a template that pictures decide.

use rtcli_tracer::Stopped;

use crate::picture::Picture;

/// A condition that the objects of a group must meet.
#[derive(Clone, Debug)]
pub struct Requirement {
    kind: &'static Kind,
    least: f64,
    /// The number of the group.
    pub group: usize,
}

impl Requirement {
    /// Returns a requirement of a kind with its bound; None if there is no such kind.
    pub fn new(kind: &str, least: f64, group: usize) -> Option<Requirement> {
        let kind = KINDS.iter().find(|known| known.name == kind)?;
        Some(Requirement { kind, least, group })
    }

    /// Returns the name of the kind.
    pub fn kind(&self) -> &'static str {
        self.kind.name
    }

    /// Returns whether an object of a picture, by its number, meets it.
    pub fn is_met(&self, picture: &mut Picture<'_>, object: usize) -> Result<bool, Stopped> {
        Ok((self.kind.value)(picture, object)? >= self.least)
    }
}

/// A kind of constraint on pictures: its name in a template, and what it bounds from below.
#[derive(Debug)]
struct Kind {
    name: &'static str,
    value: fn(&mut Picture<'_>, usize) -> Result<f64, Stopped>,
}

const KINDS: &[Kind] = &[
    Kind { name: "min_visible_pixels", value: |picture, object| Ok(picture.boxes()[object].0 as f64) },
    Kind {
        name: "min_visible_fraction",
        value: |picture, object| Ok(picture.fractions()?[object].unwrap_or_default()),
    },
];

#[cfg(test)]
mod tests {
    use super::{KINDS, Requirement};

    #[test]
    fn requirements_go_by_the_names_of_a_template() {
        for kind in KINDS {
            assert_eq!(Requirement::new(kind.name, 1.0, 0).unwrap().kind(), kind.name);
        }
        assert!(Requirement::new("apart", 1.0, 0).is_none());
    }
}
