//! Cells of lines, rectangles and connected areas, as the weave editor paints them.

use std::collections::HashSet;

use towel_designer::designer::shapes::{self, Cell};

/// The cells, none of which comes twice.
pub(super) fn set(cells: impl Iterator<Item = Cell>) -> HashSet<Cell> {
    let list: Vec<Cell> = cells.collect();
    let set: HashSet<Cell> = list.iter().copied().collect();
    assert_eq!(set.len(), list.len(), "a cell comes twice: {list:?}");
    set
}

#[test]
fn a_line_has_both_ends_no_gaps_and_stays_near_the_straight_way() {
    for to in [[0, 0], [7, 0], [0, -5], [9, 4], [-4, 9], [-6, -6], [3, -11]] {
        let from = [2, -1];
        let cells: Vec<Cell> = shapes::line(from, to).collect();
        assert_eq!((cells[0], cells[cells.len() - 1]), (from, to));
        let [dx, dy] = [0, 1].map(|axis| to[axis] - from[axis]);
        assert_eq!(cells.len() as i32, dx.abs().max(dy.abs()).max(1) + 1);
        for pair in cells.windows(2) {
            let step = [0, 1].map(|axis| (pair[1][axis] - pair[0][axis]).abs());
            assert!(step[0] <= 1 && step[1] <= 1, "a gap in {cells:?}");
        }
        for [x, y] in &cells {
            // Twice the distance along the shorter side from the straight way, times the longer side.
            let off = 2 * ((x - from[0]) * dy - (y - from[1]) * dx).abs();
            assert!(off <= dx.abs().max(dy.abs()), "{:?} to {to:?}", [x, y]);
        }
    }
}

#[test]
fn rectangles_have_their_corners_whatever_the_direction() {
    for (from, to) in [
        ([1, 2], [4, 6]),
        ([4, 2], [1, 6]),
        ([3, 3], [3, 3]),
        ([2, 5], [2, 1]),
    ] {
        let outline = set(shapes::rectangle(from, to));
        let filled = set(shapes::filled_rectangle(from, to));
        let [width, height] = [0, 1].map(|axis| (from[axis] - to[axis]).abs() + 1);
        assert_eq!(filled.len() as i32, width * height);
        let inner = (width - 2).max(0) * (height - 2).max(0);
        assert_eq!(outline.len() as i32, width * height - inner);
        assert!(outline.is_subset(&filled));
        assert!(outline.contains(&from) && outline.contains(&to));
    }
}

#[test]
fn shift_makes_lines_straight_and_rectangles_square() {
    assert_eq!(shapes::straightened([0, 0], [9, 2]), [9, 0]);
    assert_eq!(shapes::straightened([0, 0], [-2, 9]), [0, 9]);
    assert_eq!(shapes::straightened([1, 1], [6, -3]), [6, -4]);
    assert_eq!(shapes::squared([5, 5], [2, 4]), [2, 2]);
    assert_eq!(shapes::squared([5, 5], [5, 3]), [7, 3]);
}

#[test]
fn connected_cells_are_those_that_steps_from_side_to_side_reach() {
    // A maze of noise; steps over cells of the same value are followed one by one to compare with.
    let [cols, rows] = [37, 23];
    let value = |[col, row]: Cell| u32::from((col * 7 + row * 13 + col * row) % 5 < 3);
    for start in [[0, 0], [36, 22], [18, 11], [3, 20]] {
        let mut reached = HashSet::from([start]);
        let mut open = vec![start];
        while let Some([col, row]) = open.pop() {
            for next in [
                [col - 1, row],
                [col + 1, row],
                [col, row - 1],
                [col, row + 1],
            ] {
                let inside = (0..cols).contains(&next[0]) && (0..rows).contains(&next[1]);
                if inside && value(next) == value(start) && reached.insert(next) {
                    open.push(next);
                }
            }
        }
        let runs = shapes::connected([cols, rows], start, value);
        assert_eq!(set(runs.iter().flat_map(shapes::Run::cells)), reached);
    }
    assert_eq!(shapes::connected([4, 4], [4, 0], |_| 0), []);
    assert_eq!(shapes::connected([4, 4], [0, -1], |_| 0), []);
}

#[test]
fn an_area_and_a_comb_of_four_thousand_cells_a_side_are_filled_without_recursion() {
    let side = 4096;
    let all = shapes::connected([side, side], [0, 0], |_| 7_u8);
    assert_eq!(all.len(), side as usize);
    // Teeth that hang on one row: the longest list of places to look at.
    let comb = |[col, row]: Cell| row == 0 || col % 2 == 0;
    let runs = shapes::connected([side, side], [0, 0], comb);
    let cells: usize = runs.iter().map(|run| run.cols.len()).sum();
    assert_eq!(cells, (side + (side - 1) * side / 2) as usize);
}
