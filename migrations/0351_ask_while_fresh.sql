-- For how many hours after an attempt a survey about it is offered; null: as long as the survey is open. Studies hand out links afterwards.
ALTER TABLE surveys ADD COLUMN fresh_hours INTEGER CHECK (fresh_hours > 0);
UPDATE surveys SET fresh_hours = 24 WHERE after_attempts = 1 AND study_id IS NULL;
