-- Whether trainees see figures of the others of their cohort beside their own.
ALTER TABLE schools ADD COLUMN shows_others INTEGER NOT NULL DEFAULT 1 CHECK (shows_others IN (0, 1));
