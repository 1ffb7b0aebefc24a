// Levels of detail of one picture: which of them a sample shows (render::levels says why and how).

// The level of a sample of a pixel in a row of the whole picture.
fn level_of(row: u32, seed_of_pixel: u32, sample: u32) -> u32 {
    let fineness = slice.first_row_fineness + f32(row) * slice.fineness_per_row;
    var coarse = FAR;
    if fineness > 0.0 {
        coarse = 1.0 / fineness;
    }
    var level = 0u;
    while level < slice.last_level && coarse >= 2.0 {
        coarse *= 0.5;
        level += 1u;
    }
    if level < slice.last_level && coarse > 1.0 {
        level += u32(sample_set(seed_of_pixel, sample, SET_LEVEL).x < coarse - 1.0);
    }
    return level;
}
