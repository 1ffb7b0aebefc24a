//! ꟻLIP against what is known of it, and that it notices what it must.

use towel_benches::flip::flip;

use crate::pictures::{gradient, scaled, uniform};

#[test]
fn flip_sees_what_an_eye_sees() {
    let size = [32, 24];
    let (black, white) = (uniform(size, [0.0; 4]), uniform(size, [1.0; 4]));
    let picture = gradient(size);
    for same in [&black, &white, &picture] {
        assert_eq!(flip(same, same, 0.0), Ok(0.0));
    }
    // Black and white are 100 apart in the paper's colour difference, green and blue, the most that is possible, 203.3.
    // Both to the power 0.7, then from 40 % of the latter on linearly from 0.95 to 1: 0.95 + 0.05·(25.12 −
    // 16.51)/24.76.
    let most = flip(&white, &black, 0.0).unwrap();
    assert!((most - 0.96739).abs() < 1e-4, "{most}");
    assert_eq!(flip(&black, &white, 0.0), Ok(most));

    // A known pair: the same grey twice as bright is a smaller difference, and a still smaller one nearly none.
    let grey = uniform(size, [0.2, 0.2, 0.2, 1.0]);
    let brighter = |by: f32| flip(&scaled(&grey, by), &grey, 0.0).unwrap();
    assert!(brighter(1.001) < 0.01 && brighter(1.1) < brighter(2.0) && brighter(2.0) < most);

    // Both ways alike but for rounding, and a mirrored pair is as different as the pair.
    let mut other = gradient(size);
    other.pixels.rotate_right(3);
    let difference = flip(&other, &picture, 0.0).unwrap();
    assert!(difference > 0.05, "{difference}");
    assert!((flip(&picture, &other, 0.0).unwrap() - difference).abs() < 1e-6);
    let (mut picture, mut other) = (picture, other);
    picture.pixels.reverse();
    other.pixels.reverse();
    assert!((flip(&other, &picture, 0.0).unwrap() - difference).abs() < 1e-6);
}

#[test]
fn flip_is_of_the_displayed_pictures() {
    let size = [16, 16];
    let (dim, bright) = (
        uniform(size, [0.001, 0.001, 0.001, 1.0]),
        uniform(size, [1.5; 4]),
    );
    // What is beyond white looks the same; three stops darker it does not.
    let brighter = uniform(size, [3.0; 4]);
    assert_eq!(flip(&brighter, &bright, 0.0), Ok(0.0));
    assert!(flip(&brighter, &bright, -3.0).unwrap() > 0.05);
    // What is nearly black looks black; eight stops brighter it does not.
    let black = uniform(size, [0.0, 0.0, 0.0, 0.5]);
    assert!(flip(&dim, &black, 0.0).unwrap() < 0.1);
    assert!(flip(&dim, &black, 8.0).unwrap() > 0.5);
    assert!(flip(&dim, &uniform([8, 32], [0.0; 4]), 0.0).is_err());
    // One value of a colour, and a pixel that is not a number, are seen.
    for value in [0.9, f32::NAN] {
        let mut one = bright.clone();
        one.pixels[100][1] = value;
        assert!(flip(&one, &bright, 0.0).unwrap() > 1e-4, "{value}");
    }
}
