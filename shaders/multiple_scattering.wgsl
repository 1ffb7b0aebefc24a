// The light of further scatterings, estimated from one shadow ray instead of traced; definition, meaning of the numbers
// and their source: renderer-core/src/optics/multiple_scattering.rs.

// g, r and β of each mode.
const SCATTERING_MODE_FIRST: vec3<f32> = vec3<f32>(0.0606, 0.5, 0.6);
const SCATTERING_MODE_MIDDLE: vec3<f32> = vec3<f32>(0.0288, 0.88, 0.35);
const SCATTERING_MODE_LAST: vec3<f32> = vec3<f32>(0.00628, 0.975, 0.25);
const SCATTERING_LEVEL: f32 = 0.9;
const SCATTERING_FLOOR: f32 = 1.0e-4;

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
