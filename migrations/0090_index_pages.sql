-- What pages and reminders ask for without reading a table or a school: who can be asked to rate, by name, and the tasks to mark
-- pops that are due.
DROP INDEX people_who_teach;
CREATE INDEX people_who_teach ON people (school_id, display_name, id)
WHERE role = 'instructor' AND disabled_at IS NULL AND erased_at IS NULL;
CREATE INDEX segment_tasks_by_due ON segment_tasks (due_at) WHERE due_at IS NOT NULL AND withdrawn_at IS NULL;
