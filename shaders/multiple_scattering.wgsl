// The light of further scatterings, estimated from one shadow ray instead of traced; definition, meaning of the numbers
// and their source: renderer-core/src/optics/multiple_scattering.rs.

fn scattering_mode(mode: vec3<f32>, visible: f32, albedo: vec3<f32>, orders: f32) -> vec3<f32> {
    let x = albedo * mode.y;
    let rest = pow(max(x, vec3<f32>(1.0e-9)), vec3<f32>(orders));
    let series = x * (1.0 - rest) / (1.0 - x);
    return series * (mode.x * (pow(visible, mode.z) + SCATTERING_LEVEL));
}

// Mean radiance by multiple scattering around a point, per mean radiance that an unhindered light brings.
fn multiple_scattering(at: Scatter, towards_light: vec3<f32>, visibility: f32) -> vec3<f32> {
    let up = max(select(-1.0, 1.0, at.point.z >= 0.0) * towards_light.z, 0.0);
    let visible = max(visibility, SCATTERING_FLOOR);
    let orders = f32(slice.bounces - slice.path_cutoff);
    let sum = scattering_mode(SCATTERING_MODE_FIRST, visible, at.albedo, orders)
        + scattering_mode(SCATTERING_MODE_MIDDLE, visible, at.albedo, orders)
        + scattering_mode(SCATTERING_MODE_LAST, visible, at.albedo, orders);
    return 4.0 * up * sum;
}
