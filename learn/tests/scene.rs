//! Clips: their flow is exact, their masks say what vanishes, their bytes are those of their number.

use amacrine::{
    elementary::{cos, hypot, sin},
    memory::Budget,
    plane::Size,
};
use amacrine_learn::scene::{Clip, Clips, FEWEST, Motion, Photographs, SceneError, Video};
use image::{GrayImage, Luma};

const SIZE: Size = Size::new(48, 48);
const FRAMES: usize = 9;

/// Eight photographs of one size: what `light` says of (which, x, y).
fn folder(side: u32, light: impl Fn(u32, f64, f64) -> f64) -> (tempfile::TempDir, Photographs) {
    let folder = tempfile::tempdir().unwrap();
    for which in 0..FEWEST as u32 {
        let picture = GrayImage::from_fn(side, side, |x, y| {
            Luma([light(which, f64::from(x), f64::from(y)).round() as u8])
        });
        picture
            .save(folder.path().join(format!("{which}.png")))
            .unwrap();
    }
    let photographs = Photographs::folder(folder.path()).unwrap();
    (folder, photographs)
}

/// Motion that leaves light as it is.
fn plain(occluder: f64) -> Motion {
    Motion {
        occluder,
        gain: [1.0; 2],
        gamma: [1.0; 2],
        ..Motion::default()
    }
}

fn between(clip: &Clip, frame: usize, x: f32, y: f32) -> f32 {
    let (i, j) = (x.floor() as usize, y.floor() as usize);
    let (fx, fy) = (x - i as f32, y - j as f32);
    let (right, below) = ((i + 1).min(SIZE.width - 1), (j + 1).min(SIZE.height - 1));
    let at = |y: usize, x: usize| clip.light[(frame, y, x)];
    let line = |y| at(y, i) * (1.0 - fx) + at(y, right) * fx;
    line(j) * (1.0 - fy) + line(below) * fy
}

/// What the middle frame shows is in the next one where the flow says, on smooth photographs.
#[test]
fn the_flow_leads_to_the_next_frame() {
    let (_folder, photographs) = folder(200, |which, x, y| {
        let turn = 0.17 + 0.01 * f64::from(which);
        128.0 + 55.0 * sin(turn * x + 0.05 * y) + 55.0 * cos(turn * y - 0.08 * x)
    });
    let clips = Clips::new(&photographs, &plain(0.0), SIZE, FRAMES, 3).unwrap();
    let (mut off, mut still, mut count): (f32, f32, f32) = (0.0, 0.0, 0.0);
    for index in 0..40 {
        let clip = clips.clip(index);
        let flow = clip.flow.as_ref().unwrap();
        let middle = clip.middle();
        for ((y, x), seen) in flow.seen.indexed_iter() {
            let (to_x, to_y) = (x as f32 + flow.u[(y, x)], y as f32 + flow.v[(y, x)]);
            let inside = (0.0..=47.0).contains(&to_x) && (0.0..=47.0).contains(&to_y);
            assert_eq!(*seen, inside, "clip {index}, {x} {y}");
            if inside {
                let own = clip.light[(middle, y, x)];
                let far = (between(&clip, middle + 1, to_x, to_y) - own).abs();
                // Half a step of eight bits at both ends, and what lies between four pixels.
                assert!(far < 4.0, "clip {index}, {x} {y}: {far}");
                off += far;
                still += (clip.light[(middle + 1, y, x)] - own).abs();
                count += 1.0;
            }
        }
    }
    assert!(off / count < 0.6, "{}", off / count);
    assert!(still / off > 10.0, "without the flow {}", still / count);
}

/// Each photograph one shade, so that pixels say which layer they show.
#[test]
fn the_mask_says_what_vanishes() {
    let (_folder, photographs) = folder(100, |which, _, _| 20.0 + 30.0 * f64::from(which));
    let clips = Clips::new(&photographs, &plain(1.0), SIZE, FRAMES, 5).unwrap();
    let (mut hidden, mut judged) = (0, 0);
    for index in 0..60 {
        let clip = clips.clip(index);
        let flow = clip.flow.as_ref().unwrap();
        let middle = clip.middle();
        let which: f32 = clip.name.trim_end_matches(".png").parse().unwrap();
        let behind = 20.0 + 30.0 * which;
        let shades: Vec<f32> = { clip.light.iter() }
            .copied()
            .filter(|v| (v - 20.0) % 30.0 == 0.0)
            .collect();
        // Of edges, which mix both, some may look like a third.
        let count = |shade: f32| shades.iter().filter(|v| **v == shade).count();
        let front = { (0..8).map(|n| 20.0 + 30.0 * n as f32) }
            .filter(|shade| *shade != behind)
            .max_by_key(|shade| count(*shade))
            .unwrap();
        for ((y, x), seen) in flow.seen.indexed_iter() {
            let own = clip.light[(middle, y, x)];
            let (to_x, to_y) = (x as f32 + flow.u[(y, x)], y as f32 + flow.v[(y, x)]);
            if !((0.0..=47.0).contains(&to_x) && (0.0..=47.0).contains(&to_y)) {
                assert!(!seen);
                continue;
            }
            let next = between(&clip, middle + 1, to_x, to_y);
            // Only what is wholly one layer at both ends.
            let pure = |v: f32| (v - behind).abs() < 1e-3 || (v - front).abs() < 1e-3;
            if !pure(own) || !pure(next) {
                continue;
            }
            judged += 1;
            let vanishes = (own - behind).abs() < 1e-3 && (next - front).abs() < 1e-3;
            hidden += usize::from(vanishes);
            assert_eq!(*seen, !vanishes, "clip {index}, {x} {y}: {own} {next}");
            if (own - front).abs() < 1e-3 {
                assert!((next - front).abs() < 1e-3, "what is in front stays so");
            }
        }
    }
    assert!(hidden > 100 && judged > 60_000, "{hidden} of {judged}");
}

#[test]
fn clips_are_those_of_their_number() {
    let photographs = Photographs::bundled().unwrap();
    let clips = Clips::new(&photographs, &Motion::default(), SIZE, FRAMES, 7).unwrap();
    let alone: Vec<Clip> = (0..24).map(|index| clips.clip(index)).collect();
    for threads in [2, 5] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let together: Vec<Clip> = pool.install(|| {
            use rayon::prelude::*;
            (0..24_u64)
                .into_par_iter()
                .map(|index| clips.clip(index))
                .collect()
        });
        assert_eq!(together, alone);
    }
    let other = Clips::new(&photographs, &Motion::default(), SIZE, FRAMES, 8).unwrap();
    assert_ne!(other.clip(0), alone[0]);
    assert!(alone.windows(2).all(|pair| pair[0] != pair[1]));
    for clip in &alone {
        assert!(
            clip.light
                .iter()
                .all(|v| v.fract() == 0.0 && (0.0..=255.0).contains(v))
        );
        assert_eq!(clip.light.dim(), (FRAMES, 48, 48));
    }
}

/// Speeds lie where they are asked for, and as many clips have a second layer as should.
#[test]
fn motion_is_as_asked() {
    let photographs = Photographs::bundled().unwrap();
    let motion = Motion {
        turn: 0.0,
        zoom: 0.0,
        shear: 0.0,
        ..Motion::default()
    };
    let clips = Clips::new(&photographs, &motion, SIZE, FRAMES, 1).unwrap();
    let mut layered = 0;
    for index in 0..200 {
        let flow = clips.clip(index).flow.unwrap();
        let speeds: Vec<f64> = { flow.u.iter().zip(&flow.v) }
            .map(|(u, v)| hypot(f64::from(*u), f64::from(*v)))
            .collect();
        assert!(speeds.iter().all(|speed| (0.199..=2.501).contains(speed)));
        layered += usize::from(speeds.iter().any(|speed| (speed - speeds[0]).abs() > 1e-4));
    }
    // 60 of a hundred, within three standard deviations; a layer can lie outside of the crop.
    assert!((98..=141).contains(&layered), "{layered}");
}

#[test]
fn photographs_are_split_by_name() {
    let photographs = Photographs::bundled().unwrap();
    let (train, held_out) = photographs.split();
    assert_eq!((train.all().len(), held_out.all().len()), (8, 2));
    let names = |part: &Photographs| -> Vec<String> {
        part.all().iter().map(|one| one.name.to_string()).collect()
    };
    assert!(
        names(&held_out)
            .iter()
            .all(|name| !names(&train).contains(name))
    );
    assert_eq!(names(&photographs.split().1), names(&held_out));
    assert_ne!(train.checksum(), photographs.checksum());
    assert_eq!(
        photographs.checksum(),
        Photographs::bundled().unwrap().checksum()
    );
}

/// A sentence each, with the file.
#[test]
fn folders_that_make_no_clips() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let read = || Photographs::folder(path).unwrap_err().to_string();
    let gone = Photographs::folder(&path.join("gone")).unwrap_err();
    assert!(matches!(gone, SceneError::Folder { .. }) && gone.to_string().contains("gone"));
    assert!(read().ends_with(": no photographs in it"), "{}", read());
    let save = |name: &str, side| {
        GrayImage::from_pixel(side, side, Luma([9]))
            .save(path.join(name))
            .unwrap();
    };
    for n in 0..7 {
        save(&format!("{n}.png"), 64);
    }
    assert!(
        read().ends_with(": 7 photographs, at least 8 are needed"),
        "{}",
        read()
    );
    std::fs::write(path.join("text.JPG"), "no picture").unwrap();
    assert!(
        read().contains("text.JPG: no picture that can be read"),
        "{}",
        read()
    );
    std::fs::remove_file(path.join("text.JPG")).unwrap();
    save("small.png", 40);
    let photographs = Photographs::folder(path).unwrap();
    let make = |size, frames| {
        let made = Clips::new(&photographs, &Motion::default(), size, frames, 0);
        made.map(|_| ()).unwrap_err().to_string()
    };
    let small = make(SIZE, FRAMES);
    assert!(
        small.ends_with("small.png: 40x40, smaller than a crop of 48x48"),
        "{small}"
    );
    assert!(make(Size::new(8, 8), 2).contains("at least 3"));
    assert!(make(Size::new(0, 8), 9).contains("no pixels"));
    // As large as the crop is large enough, though clips see beyond its border.
    let clips = Clips::new(&photographs, &Motion::default(), Size::new(40, 40), 9, 0).unwrap();
    assert!((0..50).all(|index| clips.clip(index).light.iter().all(|v| v.is_finite())));
}

#[test]
fn video_is_a_scene_too() {
    let video = Video::open(
        "pattern:noise?width=64&height=56&frames=60&fps=240",
        Budget::from_machine(),
    )
    .unwrap();
    let (train, held_out) = video.split();
    let clips = Clips::of_video(&train, SIZE, FRAMES, 2).unwrap();
    let clip = clips.clip(3);
    assert_eq!((clip.light.dim(), clip.flow.is_none()), ((9, 48, 48), true));
    assert_ne!(clip.light, clips.clip(4).light);
    assert_eq!(clip, clips.clip(3));
    assert!(Clips::of_video(&held_out, SIZE, FRAMES, 2).is_ok());
    let short = Clips::of_video(&held_out, SIZE, 13, 2)
        .unwrap_err()
        .to_string();
    assert!(
        short.contains("60 frames; a fifth of them is held out, and each part needs 13"),
        "{short}"
    );
    let large = Clips::of_video(&train, Size::new(57, 8), 9, 2)
        .unwrap_err()
        .to_string();
    assert!(
        large.contains("64x56, smaller than a crop of 8x57"),
        "{large}"
    );
    assert!(Video::open("gone.y4m", Budget::from_machine()).is_err());
    let bundled = Video::open("bundled", Budget::from_machine()).unwrap();
    assert!(Clips::of_video(&bundled, SIZE, FRAMES, 2).is_ok());
}
