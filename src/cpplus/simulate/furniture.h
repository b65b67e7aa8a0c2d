#pragma once

#include "cpplus/simulate/scene_draft.h"

namespace cpplus {

/// Things in rooms. Frames: origin on the floor, z up; things for walls stand with their back at y = 0, front towards
/// +y, centred on x = 0. Sizes in metres are drawn at random where not given.

void add_bookshelf(SceneDraft& draft, const Rigid3& frame, double width_m);
void add_cabinet(SceneDraft& draft, const Rigid3& frame, double width_m);
void add_desk(SceneDraft& draft, const Rigid3& frame, double width_m);
void add_table(SceneDraft& draft, const Rigid3& frame, double length_m, double width_m);
void add_chair(SceneDraft& draft, const Rigid3& frame);
void add_plant(SceneDraft& draft, const Rigid3& frame);
void add_crates(SceneDraft& draft, const Rigid3& frame, int count);
void add_radiator(SceneDraft& draft, const Rigid3& frame, double width_m);
void add_rug(SceneDraft& draft, const Rigid3& frame, double length_m, double width_m);
/// A thin panel at height low_m on a wall.
void add_poster(SceneDraft& draft, const Rigid3& frame, double low_m, double width_m, double height_m);
void add_whiteboard(SceneDraft& draft, const Rigid3& frame);
void add_bench(SceneDraft& draft, const Rigid3& frame, double length_m);
/// A checkerboard on a tripod, or hung up (`hung` = lower edge at that height, 0 = tripod); adds to Scene::boards.
void add_checkerboard(SceneDraft& draft, const Rigid3& frame, double tilt_rad, double hung_m);

}  // namespace cpplus
