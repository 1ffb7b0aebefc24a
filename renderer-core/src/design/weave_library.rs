//! The weave library: the weaves that every designer of towels knows, in this program's stitch values.
//!
//! Flat weaves (plain, twill, satin, rib, waffle) are drawn as on point paper: 1 where the warp lies over the weft, 0
//! where the weft does. In pile weaves ground and pile ends take turns, one column each. A pile end is bound under one
//! pick of its group and lies over the others, and the loop stands where the gap to the group before was, at its first
//! pick. In a real terry every second pile end makes loops on the face and the others on the back; here one column
//! stands for two such neighbours and has loops on both faces (9). So a column is two ends of the loom: 13 columns a
//! centimetre are a towel of 26 ends.
//!
//! Facts, not drawings, from: Taylor, "Cotton Weaving and Designing" (terry: pile ends are up for all picks of a group
//! but one); Wolfensberger, "Theory of Silk Weaving" (counters of satins); Encyclopædia Britannica 1911, "Honeycomb"
//! (longest floats of the perfect honeycomb: 7 of the weft, 5 of the warp).

use super::{Back, Pattern, Weave};

/// A weave that can be chosen instead of painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LibraryWeave {
    /// What designers call it.
    pub name: &'static str,
    /// How it is built and what it is for.
    pub what: &'static str,
    /// What stands on the back of the cloth; `None` where the weave has no pile and does not care.
    pub back: Option<Back>,
    /// The repeat, row 0 first.
    rows: &'static [&'static [u8]],
}

impl LibraryWeave {
    /// The stitch pattern.
    pub fn pattern(&self) -> Pattern {
        let cols = self.rows.first().map_or(0, |row| row.len());
        Pattern::from_fn(cols, self.rows.len(), |col, row| self.rows[row][col])
    }

    /// Gives a design's weave this pattern, and the back that belongs to it.
    pub fn apply(&self, weave: &mut Weave) {
        weave.pattern = self.pattern();
        if let Some(back) = self.back {
            weave.back = back;
        }
    }
}

/// All of the library, in menu order.
pub const WEAVE_LIBRARY: [LibraryWeave; 8] = [
    LibraryWeave {
        name: "Plain",
        what: "Flat. Warp and weft take turns at every crossing: the firmest weave, for hems and narrow borders.",
        back: None,
        rows: &[&[1, 0], &[0, 1]],
    },
    LibraryWeave {
        name: "Twill",
        what: "Flat. Each yarn goes over two and under two, one step to the right with every pick: diagonal ribs.",
        back: None,
        rows: &[&[1, 1, 0, 0], &[0, 1, 1, 0], &[0, 0, 1, 1], &[1, 0, 0, 1]],
    },
    LibraryWeave {
        name: "Satin",
        what: "Flat. Five ends, counter 2: the warp covers four of five crossings, smooth and shiny, for borders.",
        back: None,
        rows: &[
            &[0, 1, 1, 1, 1],
            &[1, 1, 0, 1, 1],
            &[1, 1, 1, 1, 0],
            &[1, 0, 1, 1, 1],
            &[1, 1, 1, 0, 1],
        ],
    },
    LibraryWeave {
        name: "Terry 3-pick",
        what: "Loops on both faces, one for every three picks: the usual bath towel. The ground is a 2/1 rib.",
        back: Some(Back::Pattern),
        rows: &[&[1, 9, 0, 9], &[1, 0, 0, 0], &[0, 1, 1, 1]],
    },
    LibraryWeave {
        name: "Terry 4-pick",
        what: "Loops on both faces, one for every four picks: held faster and standing farther apart. The ground is \
               a 2/2 rib.",
        back: Some(Back::Pattern),
        rows: &[&[1, 9, 0, 9], &[1, 0, 0, 0], &[0, 1, 1, 1], &[0, 1, 1, 1]],
    },
    LibraryWeave {
        name: "Rib",
        what: "Flat. Two picks lie in each shed of a plain weave: fine ribs from side to side.",
        back: None,
        rows: &[&[1, 0], &[1, 0], &[0, 1], &[0, 1]],
    },
    LibraryWeave {
        name: "Waffle",
        what: "Flat. Honeycomb on eight ends and eight picks: floats that grow and shrink around hollows of \
               plain weave.",
        back: None,
        rows: &[
            &[0, 0, 0, 1, 0, 0, 0, 0],
            &[0, 0, 1, 0, 1, 0, 0, 0],
            &[0, 1, 0, 1, 0, 1, 0, 0],
            &[1, 0, 1, 1, 1, 0, 1, 0],
            &[0, 1, 1, 1, 1, 1, 0, 1],
            &[1, 0, 1, 1, 1, 0, 1, 0],
            &[0, 1, 0, 1, 0, 1, 0, 0],
            &[0, 0, 1, 0, 1, 0, 0, 0],
        ],
    },
    LibraryWeave {
        name: "Velvet",
        what: "Pile on the front only, staggered, each tuft held by one pick of a plain ground. Choose \
               cut pile to go with it.",
        back: Some(Back::None),
        rows: &[&[1, 7, 0, 0], &[0, 0, 1, 7]],
    },
];
