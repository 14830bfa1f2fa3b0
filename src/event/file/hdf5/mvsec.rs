//! The layout of the MVSEC data set (Zhu et al. 2018): `davis/left/events` and
//! `davis/right/events`, one row an event: x, y, seconds, sign.
//!
//! Times are those of the day, so they lie about 1.5e9 s after 0. The left camera is stream
//! 0, the right one is 1. The size is that of the camera's images, `image_raw`, which are left
//! out and counted, as is its motion, `imu`. Source: <https://daniilidis-group.github.io/mvsec/>.

use hdf5_pure::File;

use super::{
    super::fault::Stop,
    cameras::{Camera, Reading, Table, XYTP},
};

/// The cameras: their numbers, their events, their images and motion.
const CAMERAS: [(i32, &str, [&str; 2]); 2] = [
    (
        0,
        "davis/left/events",
        ["davis/left/image_raw", "davis/left/imu"],
    ),
    (
        1,
        "davis/right/events",
        ["davis/right/image_raw", "davis/right/imu"],
    ),
];

/// Whether a file is laid out like this.
pub fn fits(file: &File) -> bool {
    CAMERAS
        .iter()
        .any(|(_, path, _)| file.dataset(path).is_ok())
}

/// Opens the streams of events.
pub fn source(file: &File) -> Result<Reading, Stop> {
    let mut cameras = Vec::new();
    let mut seconds = true;
    for (number, path, others) in CAMERAS {
        if file.dataset(path).is_err() {
            continue;
        }
        let (table, events) = Table::rows(file, path, XYTP)?;
        seconds &= table.has_real_times()?;
        let mut camera = Camera {
            number,
            path,
            table,
            events,
            stated: None,
            size: None,
            others: 0,
        };
        for other in others {
            camera.leave_out(file, other)?;
        }
        cameras.push(camera);
    }
    Ok(Reading::new(cameras, seconds))
}
