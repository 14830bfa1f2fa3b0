//! What is shown of a scene: a slice, a part of each picture, larger pixels.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use amacrine::{
    plane::{Plane, Size},
    scene::{Frame, OpenOptions, Scene, SceneError, View, open},
};
use ndarray::{Array2, Array3, s};
use ndarray_npy::{read_npy, write_npy};

use crate::common::{good, json, refused};

const SCENE: &str = "pattern:noise?width=21&height=14&frames=12&fps=100&speed=90";

fn read(mut scene: Box<dyn Scene>) -> Result<Vec<Frame>, SceneError> {
    let mut frames = Vec::new();
    while let Some(frame) = scene.next_frame()? {
        assert_eq!(Size::of(&frame.light), scene.size());
        frames.push(frame);
    }
    if let Some(count) = scene.frames() {
        assert_eq!(frames.len() as u64, count);
    }
    Ok(frames)
}

fn shown(spec: &str, view: View) -> Result<Vec<Frame>, SceneError> {
    let options = OpenOptions {
        view,
        ..OpenOptions::default()
    };
    read(open(spec, &options)?)
}

fn sliced(text: &str) -> View {
    View {
        slice: Some(text.parse().unwrap()),
        ..View::default()
    }
}

fn cropped(text: &str) -> View {
    View {
        crop: Some(text.parse().unwrap()),
        ..View::default()
    }
}

#[test]
fn a_slice_begins_at_0() {
    let all = shown(SCENE, View::default()).unwrap();
    for (text, frames) in [
        ("..", 0..12),
        ("3..7", 3..7),
        ("..5", 0..5),
        ("9..", 9..12),
        ("30ms..70ms", 3..7),
        ("25ms..", 3..12),
        ("4..60ms", 4..6),
        ("0.05s..11", 5..11),
        ("..1s", 0..12),
    ] {
        let got = shown(SCENE, sliced(text)).unwrap();
        assert_eq!(got.len(), frames.len(), "{text}");
        for (n, (got, want)) in got.iter().zip(&all[frames]).enumerate() {
            assert_eq!(got.index, n as u64);
            assert_eq!(got.seconds, n as f64 / 100.0, "{text}");
            assert_eq!(got.light, want.light);
        }
    }
}

#[test]
fn a_crop_is_a_part_of_the_picture_as_it_is_held() {
    let folder = tempfile::tempdir().unwrap();
    let light = Array3::from_shape_fn((3, 9, 11), |(t, y, x)| (20 * t + 11 * y + x) as u8);
    let bytes = folder.path().join("u1.npy").display().to_string();
    let words = folder.path().join("u2.npy").display().to_string();
    let floats = folder.path().join("f8.npy").display().to_string();
    write_npy(&bytes, &light).unwrap();
    write_npy(&words, &light.mapv(u16::from)).unwrap();
    write_npy(&floats, &light.mapv(|l| f64::from(l) / 8.0)).unwrap();
    for (spec, unit, is_coded) in [
        (&bytes, 1.0, true),
        (&words, 1.0, true),
        (&floats, 8.0, false),
    ] {
        for (text, y, x) in [("4x3+6+5", 5, 6), ("4x3", 3, 3), ("11x9+0+0", 0, 0)] {
            let got = shown(spec, cropped(text)).unwrap();
            let Size { height, width } = got[0].light.size();
            for (t, frame) in got.iter().enumerate() {
                assert_eq!(frame.light.coded().is_some(), is_coded);
                let want = light.slice(s![t, y..y + height, x..x + width]);
                assert_eq!(
                    frame.light.mapv(|l| unit * l),
                    want.mapv(f64::from),
                    "{text}"
                );
            }
        }
    }
}

/// Against the mean of a picture in which each pixel stands so often that all shares are whole.
#[test]
fn larger_pixels_have_the_mean_of_their_light() {
    let all = shown(SCENE, View::default()).unwrap();
    for size in [
        Size::new(14, 21),
        Size::new(7, 7),
        Size::new(4, 9),
        Size::new(1, 1),
    ] {
        let resize = View {
            resize: Some(size),
            ..View::default()
        };
        for (got, from) in shown(SCENE, resize).unwrap().iter().zip(&all) {
            let fine = Array2::from_shape_fn((14 * size.height, 21 * size.width), |(y, x)| {
                from.light[(y / size.height, x / size.width)]
            });
            for ((y, x), light) in got.light.indexed_iter() {
                let own = fine.slice(s![14 * y..14 * (y + 1), 21 * x..21 * (x + 1)]);
                assert!((light - own.mean().unwrap()).abs() < 1e-9, "{size}");
            }
        }
    }
}

#[test]
fn verbs_show_what_numpy_would_cut_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let frames = shown(SCENE, View::default()).unwrap();
    let whole: Vec<Plane<f64>> = frames.iter().map(|frame| (*frame.light).clone()).collect();
    let views: Vec<_> = whole[2..10]
        .iter()
        .map(|l| l.slice(s![2..12, 3..19]))
        .collect();
    write_npy(
        at.join("part.npy"),
        &ndarray::stack(ndarray::Axis(0), &views).unwrap(),
    )
    .unwrap();
    let part = ["--slice", "20ms..10", "--crop", "16x10+3+2"];
    let run = |scene: &str, file: &str, more: &[&str]| {
        let words = [
            "run", "--sensor", "dvs", "--scene", scene, "-o", file, "--json",
        ];
        json(at, &[&words[..], more].concat())
    };
    let cut = run("part.npy", "cut.npy", &["--fps", "100"]);
    let own = run(SCENE, "own.npy", &part);
    assert_eq!(own["events"], cut["events"]);
    assert!(own["events"].as_u64().unwrap() > 20);
    assert_eq!(
        fs::read(at.join("own.npy")).unwrap(),
        fs::read(at.join("cut.npy")).unwrap()
    );
    // The command of a report has the same part.
    let words = [
        "feasibility",
        "csdvs-3",
        "--threshold",
        "40",
        "--chips",
        "1",
        "-o",
        "r.html",
    ];
    let text = good(at, &[&words[..], &["--scene", SCENE], &part].concat());
    let page = fs::read_to_string(at.join("r.html")).unwrap();
    for word in ["--slice 20000us..10", "--crop 16x10+3+2"] {
        assert!(page.contains(word), "{text}");
    }
    let small = run(SCENE, "small.npy", &["--resize", "7x7"]);
    let counts: Array3<f64> = {
        let light: Vec<_> = whole.iter().map(mean_of_blocks).collect();
        let views: Vec<_> = light.iter().map(|light| light.view()).collect();
        ndarray::stack(ndarray::Axis(0), &views).unwrap()
    };
    write_npy(at.join("means.npy"), &counts).unwrap();
    let means = run("means.npy", "means-events.npy", &["--fps", "100"]);
    assert_eq!(small["events"], means["events"]);
    let back: Array3<f64> = read_npy(at.join("means.npy")).unwrap();
    assert_eq!(back.dim(), (12, 7, 7));
}

/// Of 2 rows and 3 columns.
fn mean_of_blocks(light: &Plane<f64>) -> Plane<f64> {
    Plane::from_shape_fn((7, 7), |(y, x)| {
        light
            .slice(s![2 * y..2 * y + 2, 3 * x..3 * x + 3])
            .mean()
            .unwrap()
    })
}

#[test]
fn what_a_scene_does_not_have_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at: &Path = folder.path();
    let base = ["run", "--sensor", "dvs", "--scene", SCENE];
    for (more, words) in [
        (
            ["--slice", "1s..2s"],
            vec!["holds no frame", "12 frames at 100 frames/s"],
        ),
        (
            ["--slice", "10us..20us"],
            vec![
                "the slice 10us..20us holds no frame",
                "the scene has frames before and after it, at 100 frames/s",
            ],
        ),
        (["--slice", "5..3"], vec!["FROM is not before TO"]),
        (["--slice", "3"], vec!["give FROM..TO"]),
        (["--slice", "a..3"], vec!["`a` is no time"]),
        (
            ["--crop", "22x3"],
            vec!["the crop 22x3 does not lie within pictures of 21x14"],
        ),
        (["--crop", "2x3+20+0"], vec!["2x3+20+0", "21x14"]),
        (["--crop", "0x3"], vec!["give WIDTHxHEIGHT"]),
        (["--crop", "2x3+1"], vec!["give WIDTHxHEIGHT"]),
        (
            ["--resize", "42x28"],
            vec![
                "pictures of 21x14 cannot be enlarged to 42x28",
                "not larger",
            ],
        ),
    ] {
        refused(at, &[&base[..], &more].concat(), &words);
    }
}
