-- A guest practises at a station by a code and has no account: the same column with one more value. The role of everybody stays.
ALTER TABLE people ADD COLUMN role_again TEXT NOT NULL DEFAULT 'trainee'
    CHECK (role_again IN ('trainee', 'instructor', 'administrator', 'guest'));
UPDATE people SET role_again = role;
DROP INDEX people_by_role;
DROP INDEX people_who_teach;
ALTER TABLE people DROP COLUMN role;
ALTER TABLE people RENAME COLUMN role_again TO role;
CREATE INDEX people_by_role ON people (school_id, role) WHERE disabled_at IS NULL;
CREATE INDEX people_who_teach ON people (school_id, display_name, id)
WHERE role = 'instructor' AND disabled_at IS NULL AND erased_at IS NULL;

-- The sums of the whole school are of its trainees: those who teach practise, too, and count in none.
DELETE FROM tallies WHERE cohort_id = zeroblob(16);
INSERT INTO tallies (school_id, cohort_id, month, attempts, passes, points)
SELECT school_id, zeroblob(16), month, count(*), sum(passed), sum(score)
FROM (SELECT p.school_id, h.value ->> '$[3]' AS passed, h.value ->> '$[2]' AS score,
        12 * CAST(strftime('%Y', (h.value ->> '$[1]') / 1000000, 'unixepoch') AS INTEGER)
        + CAST(strftime('%m', (h.value ->> '$[1]') / 1000000, 'unixepoch') AS INTEGER) - 1 AS month
      FROM people q JOIN practice p ON p.school_id = q.school_id AND p.trainee_id = q.id, json_each(p.history) h
      WHERE q.role = 'trainee')
GROUP BY school_id, month;
