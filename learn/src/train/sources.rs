//! The clips of a task: those that are trained on, and those that are held out.

use amacrine::{memory::Budget, plane::Size};

use crate::{
    scene::{Clips, Photographs, Video},
    task::{Goal, Task},
};

use super::error::TrainError;

/// Which clips are trained on, and which are held out.
const TRAINING: u64 = 1;
const HELD_OUT: u64 = 2;

/// Clips to train on, held-out clips, and what tells these sources from others.
pub(super) fn clips(task: &Task, memory: Budget) -> Result<(Clips, Clips, String), TrainError> {
    let scenes = &task.scenes;
    let crop = Size::new(task.crop, task.crop);
    let large = Size::new(task.test.1, task.test.1);
    let flow = task.goal == Goal::Flow;
    let kept = |clips: Clips| clips.kept(scenes.clips, flow);
    if let Some(video) = &scenes.video {
        let video = Video::open(video, memory)?;
        let (training, held_out) = video.split();
        return Ok((
            kept(Clips::of_video(&training, crop, scenes.frames, TRAINING)?),
            Clips::of_video(&held_out, large, scenes.frames, HELD_OUT)?,
            video.checksum(),
        ));
    }
    let photographs = match &scenes.photographs {
        Some(folder) => Photographs::folder(folder)?,
        None => Photographs::bundled()?,
    };
    let (training, held_out) = photographs.split();
    Ok((
        kept(Clips::new(
            &training,
            &scenes.motion,
            crop,
            scenes.frames,
            TRAINING,
        )?),
        Clips::new(&held_out, &scenes.motion, large, scenes.frames, HELD_OUT)?,
        photographs.checksum(),
    ))
}
