// The client of TrajectoryService: fetched with the views that ask it, not with the page.
import { lazily } from './client';
import { TrajectoryService } from './gen/driftwise/v1/trajectory_service_pb';

export const trajectoryApi = lazily(TrajectoryService);
