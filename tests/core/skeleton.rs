//! The ground weave's surface (MODEL.md §7).

use std::f64::consts::PI;

use renderer_core::design::{Pattern, SkeletonDesign, SkeletonHeight, Weave};
use renderer_core::sampling::Pcg;
use renderer_core::scene::{Face, SheetGeometry, Skeleton};

const SHEET: SheetGeometry = SheetGeometry {
    warps: 8,
    wefts: 6,
    pitch_x_mm: 0.8,
    pitch_y_mm: 0.6,
    region: None,
};

fn skeleton(rows: &[&[u8]], design: &SkeletonDesign) -> Skeleton {
    let rows: Vec<Vec<u8>> = rows.iter().map(|row| row.to_vec()).collect();
    let weave = Weave {
        pattern: Pattern::try_from(rows).unwrap(),
        ..Weave::default()
    };
    Skeleton::new(&weave, design)
}

fn round_yarns() -> SkeletonDesign {
    SkeletonDesign {
        warp_radius: 0.25,
        weft_radius: 0.2,
        crimp: 0.3,
        ..SkeletonDesign::default()
    }
}

/// Heights are in f64 from radii and crimp stored as f32: relative rounding 6e-8 of some tenths of a mm.
fn assert_mm(found: Option<f64>, expected: f64) {
    let found = found.expect("there is a yarn");
    assert!((found - expected).abs() < 1e-7, "{found}, not {expected}");
}

#[test]
fn alternating_yarns_follow_the_papers_sine() {
    // Equation 2 is sin(2πy′/Step + d) with Step = 2 pitches, d = 0 where the first crossing is over, else π.
    let skeleton = skeleton(&[&[1, 0], &[0, 1]], &round_yarns());
    for k in 0..600 {
        let cells = f64::from(k) * 0.01;
        let sine = (PI * cells).sin();
        for (warp, sign) in [(0, 1.0), (1, -1.0), (4, 1.0)] {
            assert!((skeleton.warp_profile(warp, cells) - sign * sine).abs() < 1e-12);
        }
        // Where a warp is over, the weft is under.
        for (weft, sign) in [(0, -1.0), (1, 1.0)] {
            assert!((skeleton.weft_profile(weft, cells) - sign * sine).abs() < 1e-12);
        }
    }
}

#[test]
fn yarns_stay_over_between_two_crossings_where_they_are_over() {
    let skeleton = skeleton(&[&[1], &[7], &[0], &[8], &[9]], &round_yarns());
    for (y, s) in [
        (0.5, 1.0),
        (1.0, 1.0),
        (1.5, 1.0),
        (2.0, 0.0),
        (2.25, -(PI / 4.0).sin()),
        (3.0, -1.0),
        (4.0, 0.0),
        (5.0, 1.0),
    ] {
        let found = skeleton.warp_profile(0, y);
        assert!((found - s).abs() < 1e-12, "s({y}) = {found}, not {s}");
    }
}

#[test]
fn crossings_have_the_height_of_the_yarn_on_top() {
    let skeleton = skeleton(&[&[1, 0], &[0, 1]], &round_yarns());
    let height = |place, face| skeleton.height_mm(&SHEET, place, face);
    // Crossing (0, 0): the warp (radius 0.25) is on the front, the weft (0.2) on the back, each 0.3 from the middle.
    assert_mm(height([0.5, 0.5], Face::Front), 0.3 + 0.25);
    assert_mm(height([0.5, 0.5], Face::Back), 0.3 + 0.2);
    // Crossing (1, 0) the other way round.
    assert_mm(height([1.5, 0.5], Face::Front), 0.3 + 0.2);
    assert_mm(height([1.5, 0.5], Face::Back), 0.3 + 0.25);
    // Between crossings along warp 0: s = 0, only the warp's own roundness.
    assert_mm(height([0.5, 1.0], Face::Front), 0.25);
    // Beside its middle the warp is lower: sqrt(0.25² − 0.15²) = 0.2.
    assert_mm(height([0.5 + 0.15 / 0.8, 1.0], Face::Front), 0.2);
    // Corners of cells are gaps here.
    assert_eq!(height([1.0, 1.0], Face::Front), None);
}

#[test]
fn the_papers_product_has_the_sign_of_the_profile() {
    let paper = SkeletonDesign {
        height: SkeletonHeight::Paper,
        ..round_yarns()
    };
    let skeleton = skeleton(&[&[1, 0], &[0, 1]], &paper);
    let height = |place, face| skeleton.height_mm(&SHEET, place, face);
    assert_mm(height([0.5, 0.5], Face::Front), 0.25);
    assert_mm(height([0.5, 1.0], Face::Front), 0.0);
    assert_mm(height([0.5, 0.5], Face::Back), 0.2);
}

#[test]
fn gaps_have_the_share_of_the_product() {
    let mut random = Pcg::new(3, 0);
    let mut next = || f64::from(random.next_float());
    for design in [
        round_yarns(),
        SkeletonDesign {
            warp_radius: 0.1,
            weft_radius: 0.1,
            ..round_yarns()
        },
        SkeletonDesign {
            warp_radius: 0.5,
            ..round_yarns()
        },
    ] {
        let skeleton = skeleton(&[&[1, 0], &[0, 1]], &design);
        let points = 40_000;
        let gaps = (0..points)
            .filter(|_| {
                let place = [8.0 * next(), 6.0 * next()];
                skeleton.height_mm(&SHEET, place, Face::Front).is_none()
            })
            .count();
        let (found, share) = (gaps as f64 / f64::from(points), skeleton.gap_share(&SHEET));
        // Four standard errors of a binomial share.
        let tolerance = 4.0 * (share * (1.0 - share) / f64::from(points)).sqrt();
        assert!((found - share).abs() <= tolerance, "{found}, not {share}");
    }
}

#[test]
fn heights_go_on_beyond_the_border() {
    let skeleton = skeleton(&[&[1, 0], &[0, 1]], &round_yarns());
    for place in [[0.5, -0.3], [0.5, 6.4]] {
        let inside = [
            place[0],
            place[1] + 2.0 * if place[1] < 0.0 { 1.0 } else { -1.0 },
        ];
        let height = skeleton.height_mm(&SHEET, place, Face::Front);
        assert_mm(
            height,
            skeleton.height_mm(&SHEET, inside, Face::Front).unwrap(),
        );
    }
}
