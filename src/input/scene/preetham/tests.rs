use super::*;

fn model(turbidity: f64, elevation_deg: f64) -> SkyModel {
    let (sin, cos) = elevation_deg.to_radians().sin_cos();
    SkyModel::new(turbidity, DVec3::new(cos, sin, 0.0), 0.3)
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn toward(elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
    let ((se, ce), (sa, ca)) = (
        elevation_deg.to_radians().sin_cos(),
        azimuth_deg.to_radians().sin_cos(),
    );
    DVec3::new(ce * ca, se, ce * sa)
}

/// Worked by hand from the paper's formulae at T = 3, θs = 30°: χ = (4/9 − 1/40)·2π/3, Yz = 7.1649 tan χ + 1.7727.
#[test]
fn zenith_luminance_follows_the_paper_and_is_a_few_kcd() {
    let chi = (4.0_f64 / 9.0 - 3.0 / 120.0) * (2.0 * PI / 3.0);
    let expected = 7.1649 * chi.tan() + 1.7727;
    let got = luminance(model(3.0, 60.0).radiance(DVec3::Y));
    assert!((got / expected - 1.0).abs() < 2e-3, "{got} {expected}");
    for (turbidity, elevation) in [(2.0, 60.0), (2.5, 45.0), (3.0, 60.0), (3.0, 30.0)] {
        let got = luminance(model(turbidity, elevation).radiance(DVec3::Y));
        assert!(
            (2.0..12.0).contains(&got),
            "T {turbidity}, {elevation}°: {got} kcd/m²"
        );
    }
}

#[test]
fn the_noon_horizon_is_brighter_than_the_zenith_and_the_zenith_is_blue() {
    let sky = model(2.5, 60.0);
    let zenith = sky.radiance(DVec3::Y);
    assert!(luminance(sky.radiance(toward(1.0, 180.0))) > luminance(zenith));
    assert!(zenith[2] > 1.5 * zenith[0], "{zenith:?}");
}

#[test]
fn the_sky_is_brighter_near_the_sun() {
    let sky = model(3.0, 30.0);
    let at = |azimuth| luminance(sky.radiance(toward(30.0, azimuth)));
    assert!(
        at(5.0) > at(30.0) && at(30.0) > at(90.0),
        "{} {} {}",
        at(5.0),
        at(30.0),
        at(90.0)
    );
}

#[test]
fn directions_below_the_horizon_equal_the_lowest_elevation() {
    let sky = SkyModel::new(3.0, DVec3::Y, 0.3);
    let low = sky.radiance(toward(0.2, 40.0));
    assert!(low.iter().all(|v| v.is_finite() && *v > 0.0));
    assert!(
        sky.radiance(toward(-60.0, 40.0))
            .iter()
            .all(|v| v.is_finite() && *v > 0.0)
    );
}

#[test]
fn a_low_sun_is_redder_and_weaker() {
    let mut previous = [f64::INFINITY; 3];
    for elevation in [90.0, 60.0, 30.0, 12.0, 5.0, 1.0, 0.05] {
        let sun = model(2.5, elevation).sun_irradiance_klx();
        assert!(sun[0] > sun[1] && sun[1] > sun[2], "{elevation}°: {sun:?}");
        assert!(
            (0..3).all(|c| sun[c] < previous[c] && sun[c] > 0.0),
            "{elevation}°: {sun:?}"
        );
        assert!(previous[0].is_infinite() || sun[0] / sun[2] > previous[0] / previous[2]);
        previous = sun;
    }
    let noon = luminance(model(2.5, 60.0).sun_irradiance_klx());
    assert!((70.0..115.0).contains(&noon), "{noon} klx");
}

#[test]
fn everything_is_finite_and_sane_over_the_whole_range() {
    for turbidity in [1.7, 1.9, 2.0, 2.5, 4.0, 6.0, 8.0, 10.0] {
        for elevation in [0.05, 0.5, 2.0, 5.0, 12.0, 30.0, 60.0, 89.0, 90.0] {
            let sky = model(turbidity, elevation);
            let sums = [
                sky.mean_radiance(),
                sky.sky_irradiance_klx(),
                sky.ground_radiance(),
            ];
            let values = sums
                .iter()
                .flatten()
                .chain(sky.perez().zenith.iter())
                .copied()
                .collect::<Vec<_>>();
            assert!(
                values.iter().all(|v| v.is_finite() && *v > 0.0),
                "T {turbidity}, {elevation}°: {values:?}"
            );
            assert!(
                sky.sun_irradiance_klx()
                    .iter()
                    .all(|v| v.is_finite() && *v >= 0.0)
            );
            let mean = luminance(sky.mean_radiance());
            assert!(
                mean < 40.0,
                "T {turbidity}, {elevation}°: mean {mean} kcd/m²"
            );
        }
    }
}

#[test]
fn turbidity_below_two_uses_the_sky_of_two_and_its_own_sun() {
    let (clear, two) = (model(1.7, 45.0), model(2.0, 45.0));
    assert_eq!(clear.perez(), two.perez());
    assert!(clear.sun_irradiance_klx()[2] > two.sun_irradiance_klx()[2]);
}

#[test]
fn ground_radiance_adds_sun_and_sky() {
    let sky = model(3.0, 30.0);
    let (sun, diffuse, ground) = (
        sky.sun_irradiance_klx(),
        sky.sky_irradiance_klx(),
        sky.ground_radiance(),
    );
    for c in 0..3 {
        assert!((ground[c] - 0.3 / PI * (0.5 * sun[c] + diffuse[c])).abs() < 1e-9);
        // A sky brighter toward the horizon lights a plane with less than π × its mean.
        assert!(
            diffuse[c] > 0.5 * PI * sky.mean_radiance()[c]
                && diffuse[c] < 1.5 * PI * sky.mean_radiance()[c]
        );
    }
}

#[test]
fn the_export_reproduces_the_radiance() {
    let (sky, direction) = (model(4.0, 20.0), toward(35.0, 70.0));
    let PerezSky { perez, zenith } = sky.perez();
    let gamma = direction.dot(toward(20.0, 0.0)).acos();
    let value: Vec<f64> = (0..3)
        .map(|i| {
            let k = |row: usize| perez[row][i];
            zenith[i]
                * (1.0 + k(0) * (k(1) / direction.y).exp())
                * (1.0 + k(2) * (k(3) * gamma).exp() + k(4) * gamma.cos().powi(2))
        })
        .collect();
    // D65-based sRGB: Y of the colour is the luminance.
    assert!((luminance(sky.radiance(direction)) / value[0] - 1.0).abs() < 2e-3);
    assert!(perez.iter().all(|row| row[3] == 0.0));
}

#[test]
fn optical_mass_is_one_overhead_and_about_37_at_the_horizon() {
    assert!((optical_mass(1.0) - 1.0).abs() < 2e-3);
    assert!((optical_mass(0.5) - 2.0).abs() < 2e-2);
    assert!((35.0..38.0).contains(&optical_mass(0.0)));
}

#[test]
fn the_quadrature_has_converged() {
    let sky = model(2.0, 0.05);
    let (rows, columns) = (400, 400);
    let mut sum = 0.0;
    for row in 0..rows {
        let elevation = ((row as f64 + 0.5) / rows as f64).asin().to_degrees();
        sum += (0..columns)
            .map(|c| {
                luminance(
                    sky.radiance(toward(elevation, (c as f64 + 0.5) * 360.0 / columns as f64)),
                )
            })
            .sum::<f64>();
    }
    let fine = sum / (rows * columns) as f64;
    assert!((luminance(sky.mean_radiance()) / fine - 1.0).abs() < 0.01);
}
