-- What people wrote may be made unreadable when somebody is erased. Judgements stay as they were made, and still nothing of them
-- changes but the words, and these only into the mark that says so.
DROP TRIGGER score_overrides_never_change;
CREATE TRIGGER score_overrides_never_change BEFORE UPDATE ON score_overrides
WHEN NOT (NEW.reason = '[erased]' AND NEW.id = OLD.id AND NEW.school_id = OLD.school_id
    AND NEW.session_id = OLD.session_id AND NEW.score IS OLD.score AND NEW.passed IS OLD.passed
    AND NEW.made_by = OLD.made_by AND NEW.made_at = OLD.made_at)
BEGIN SELECT RAISE(ABORT, 'an override never changes: another one is added'); END;

DROP TRIGGER finished_ratings_never_change;
CREATE TRIGGER finished_ratings_never_change BEFORE UPDATE ON ratings
WHEN OLD.finished_at IS NOT NULL AND NOT (NEW.id = OLD.id AND NEW.school_id = OLD.school_id AND NEW.round_id = OLD.round_id
    AND NEW.session_id = OLD.session_id AND NEW.rater_id = OLD.rater_id AND NEW.finished_at IS OLD.finished_at
    AND NEW.may_know = OLD.may_know AND json_array_length(NEW.answers) = json_array_length(OLD.answers)
    AND NOT EXISTS (SELECT 1 FROM json_each(NEW.answers) n JOIN json_each(OLD.answers) o ON o.key = n.key
        WHERE (n.value IS NOT o.value OR n.type <> o.type) AND NOT (o.type = 'text' AND n.value = '[erased]')))
BEGIN SELECT RAISE(ABORT, 'a finished rating never changes'); END;

ALTER TABLE sessions ADD COLUMN recording_erased_at INTEGER; -- since when the recording is gone, with whoever made it
CREATE INDEX sessions_without_recording ON sessions (recording_erased_at) WHERE recording_erased_at IS NOT NULL;

ALTER TABLE schools ADD COLUMN erase_recordings INTEGER NOT NULL DEFAULT 0 CHECK (erase_recordings IN (0, 1)); -- with whoever made them
