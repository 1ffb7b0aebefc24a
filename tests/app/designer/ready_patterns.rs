//! Ready patterns: what their names say.

use renderer_core::design::{Pattern, Stitch, WEAVE_LIBRARY};

/// The longest stretch of equal values in a ring, 0 if all are equal.
fn longest_float(ring: &[bool], over: bool) -> usize {
    if ring.iter().all(|value| *value == over) {
        return usize::MAX;
    }
    let twice = ring.iter().chain(ring);
    let (mut longest, mut now) = (0, 0);
    for value in twice {
        now = if *value == over { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    longest
}

#[test]
fn ready_patterns_are_what_their_names_say() {
    let of = |name: &str| {
        let found = WEAVE_LIBRARY.iter().find(|ready| ready.name == name);
        found.expect("a ready pattern").pattern()
    };
    let over = |pattern: &Pattern, col: usize, row: usize| {
        pattern.stitch(col as i64, row as i64).warp_over
    };
    for ready in WEAVE_LIBRARY {
        let pattern = ready.pattern();
        let (cols, rows) = (pattern.cols(), pattern.rows());
        assert!(
            pattern
                .values()
                .iter()
                .all(|v| Stitch::from_value(*v).is_some()),
            "{}",
            ready.name
        );
        // Every yarn is held: it goes over somewhere and under somewhere.
        for col in 0..cols {
            let warp: Vec<bool> = (0..rows).map(|row| over(&pattern, col, row)).collect();
            assert!(
                warp.contains(&true) && warp.contains(&false),
                "{}: warp {col} is loose",
                ready.name
            );
        }
        for row in 0..rows {
            let weft: Vec<bool> = (0..cols).map(|col| over(&pattern, col, row)).collect();
            assert!(
                weft.contains(&true) && weft.contains(&false),
                "{}: weft {row} is loose",
                ready.name
            );
        }
    }
    // Satin of five ends: one weft over in each row and column, none beside the next.
    let satin = of("Satin");
    let binds = |row: i64| (0..5).find(|col| satin.at(*col, row) == 0);
    for row in 0..5 {
        let step = (binds(row + 1).unwrap() - binds(row).unwrap()).rem_euclid(5);
        assert_eq!(step, 2, "the counter of the satin at row {row}");
    }
    // Twill: each row is the one before, one warp to the right.
    let twill = of("Twill");
    assert_eq!(twill.shifted(1, 1), twill);
    assert_eq!(of("Plain").shifted(1, 1), of("Plain"));
    // Waffle: floats of 5 over the weft and of 7 over the warp are the longest (Encyclopædia Britannica, "Honeycomb").
    let waffle = of("Waffle");
    let warp = |col: usize| {
        (0..8)
            .map(|row| over(&waffle, col, row))
            .collect::<Vec<_>>()
    };
    let weft = |row: usize| {
        (0..8)
            .map(|col| over(&waffle, col, row))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        (0..8).map(|col| longest_float(&warp(col), true)).max(),
        Some(5)
    );
    assert_eq!(
        (0..8).map(|row| longest_float(&weft(row), false)).max(),
        Some(7)
    );
    assert_eq!(
        waffle.mirrored_left_right().shifted(-1, 0),
        waffle,
        "point draft"
    );
    // Terry: a pile end is bound under one pick of its group and has one loop on each face.
    for (name, picks) in [("Terry 3-pick", 3), ("Terry 4-pick", 4)] {
        let terry = of(name);
        assert_eq!((terry.cols(), terry.rows()), (4, picks));
        for col in [1, 3] {
            let pile: Vec<u8> = (0..picks).map(|row| terry.at(col, row as i64)).collect();
            assert_eq!(pile.iter().filter(|v| **v == 9).count(), 1, "{name}");
            assert_eq!(pile.iter().filter(|v| **v == 0).count(), 1, "{name}");
        }
        for row in 0..picks as i64 {
            assert_ne!(
                terry.at(0, row),
                terry.at(2, row),
                "{name}: ground ends take turns"
            );
        }
    }
    let velvet = of("Velvet");
    assert!(velvet.values().contains(&7) && !velvet.values().iter().any(|v| matches!(v, 8 | 9)));
}
