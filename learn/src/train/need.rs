//! What training and judging will hold, worked out before anything of it is there.

use amacrine::{memory::Need, plane::Size};

use crate::{
    arm::{Arm, Sight},
    network::Network,
    scene::PLACE,
    task::{Goal, Task},
};

/// Bytes of a value of a clip: its light, the light with noise, and in half of a step's time a copy.
const LIGHT: usize = 12;

/// Bytes of a cell in a frame: its voxel, its count, and its distance from the memory.
const CELL: usize = 12;

/// Held-out clips whose answers are worked out together.
const TOGETHER: usize = 32;

/// What a run holds with so many arms side by side, the largest of these.
#[must_use]
pub fn of_run(task: &Task, arms: &[&Arm], together: usize) -> Need {
    let mut each: Vec<usize> = arms.iter().map(|arm| of_arm(task, arm)).collect();
    each.sort_unstable_by(|a, b| b.cmp(a));
    let held = |sum: u128, bytes: &usize| sum.saturating_add(*bytes as u128);
    let all = each.iter().take(together).fold(0, held);
    let what = if together == 1 {
        "an arm".to_owned()
    } else {
        format!("{together} arms side by side")
    };
    Need::new()
        .and(what, all)
        .and("clips that are kept", of_clips(task))
}

/// Bytes of an arm while it is trained or judged, whichever is more.
#[must_use]
pub fn of_arm(task: &Task, arm: &Arm) -> usize {
    let network = |side, clips| {
        let network = Network::<f32>::new(task.plan(arm), Size::new(side, side), clips);
        (
            network.parameters(),
            network.shape().pictures(),
            network.map_bytes(),
        )
    };
    let light = |side: usize, clips: usize| {
        let values = clips * task.scenes.frames * side * side;
        values.saturating_mul(LIGHT + CELL * arm.kinds())
    };
    let (clips, side) = (task.test.0 as usize, task.test.1);
    let judged = light(side, clips);
    if arm.sight == Sight::Blend {
        // No network, and no step.
        return judged;
    }
    let (weights, pictures, maps) = network(task.crop, task.batch);
    let groups = task.batch.div_ceil(pictures);
    // Maps there and back of all clips, and a gradient of each group of them.
    let step = (2 * maps + 4 * weights)
        .saturating_mul(groups)
        .saturating_add(light(task.crop, task.batch));
    // Of groups that are judged one after the other, on each thread one.
    let (_, pictures, maps) = network(side, clips.min(TOGETHER));
    let groups = clips.min(TOGETHER).div_ceil(pictures);
    let judged = judged.saturating_add(maps.saturating_mul(groups.min(threads())));
    // Weights, their moments, and both in the order of the loops.
    step.max(judged).saturating_add(20 * weights)
}

/// Bytes of the clips that are kept in the end.
fn of_clips(task: &Task) -> u128 {
    let drawn = u128::from(task.steps).saturating_mul(task.batch as u128);
    let pixels = (task.crop * task.crop) as u128;
    let flow = if task.goal == Goal::Flow { 9 } else { 0 };
    let each = (task.scenes.frames as u128 + flow) * pixels;
    let kept = u128::from(task.scenes.clips);
    kept.min(drawn) * each + kept * PLACE as u128
}

fn threads() -> usize {
    rayon::current_num_threads()
}
