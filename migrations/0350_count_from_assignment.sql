-- Whether only attempts since it was assigned count. As it was until now: of an exercise they alone did, of a course every attempt.
ALTER TABLE assignments ADD COLUMN since_only INTEGER NOT NULL DEFAULT 0 CHECK (since_only IN (0, 1));
UPDATE assignments SET since_only = 1 WHERE exercise_id IS NOT NULL;
