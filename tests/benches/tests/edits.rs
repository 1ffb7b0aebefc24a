//! `edits`: its table, what it writes, and what it refuses.

use std::fs;

use super::{folder, run};

#[test]
fn edits_are_timed_made_and_taken_back() {
    let folder = folder();
    let common = ["edits", "plain.toml", "--size", "20x10", "--repeats", "2"];
    let edits = [
        "--edit",
        "length.value=2",
        "--edit",
        "light.sun[0].elevation=20",
        "--method",
        "tracked",
        "-o",
        "edits.json",
    ];
    let output = run(folder.path(), &[&common[..], &edits].concat());
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    // A heading, and a line for each way there and back.
    assert_eq!(
        String::from_utf8_lossy(&output.stdout).lines().count(),
        1 + 8
    );
    let written = fs::read(folder.path().join("edits.json")).unwrap();
    let rows: serde_json::Value = serde_json::from_slice(&written).unwrap();
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 8);
    for (k, row) in rows.iter().enumerate() {
        let expected = ["length.value=2", "light.sun[0].elevation=20"][k / 4];
        assert_eq!(row["edit"], expected);
        assert_eq!(row["made"], k % 2 == 0);
        for kind in ["wall", "processor"] {
            // Linux tells the processor's time; elsewhere there is none.
            let seconds = |part: &str| row[part][kind].as_f64();
            let Some(total) = seconds("total") else {
                assert!(kind == "processor" && !cfg!(target_os = "linux"));
                continue;
            };
            let parts = ["compile", "upload", "sample"].map(|part| seconds(part).unwrap());
            assert!(parts.iter().all(|part| *part >= 0.0) && parts[0] > 0.0 && parts[2] > 0.0);
            // Sums of three numbers in another order: rounding alone.
            assert!((total - parts.iter().sum::<f64>()).abs() < 1e-9);
        }
    }
    let fails = |more: &[&str], says: &[&str]| {
        let output = run(folder.path(), &[&common[..], more].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {errors}");
        for part in says {
            assert!(errors.contains(part), "{more:?}: no {part:?} in: {errors}");
        }
        assert!(output.stdout.is_empty(), "{more:?}");
    };
    fails(&[], &["--edit"]);
    fails(
        &["--edit", "length.value=-1"],
        &["length.value is -1", "0 to 100"],
    );
    fails(&["--edit", "length.value"], &["PATH=VALUE"]);
}
