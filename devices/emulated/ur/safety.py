"""What stops an emulated arm, and what sets it going again.

Numbers as in Universal Robots' RTDE guide; how hard it brakes is a guess, the real one does so as its joints allow.
"""

RUNNING, IDLE, POWER_OFF = 7, 5, 3
ROBOT_MODES = {RUNNING: "RUNNING", IDLE: "IDLE", POWER_OFF: "POWER_OFF"}
NORMAL, PROTECTIVE_STOP, ROBOT_EMERGENCY_STOP = 1, 3, 7
SAFETY = {NORMAL: "NORMAL", PROTECTIVE_STOP: "PROTECTIVE_STOP", ROBOT_EMERGENCY_STOP: "ROBOT_EMERGENCY_STOP"}
SAFETY_BITS = {NORMAL: 1 << 0, PROTECTIVE_STOP: 1 << 2 | 1 << 10, ROBOT_EMERGENCY_STOP: 1 << 6 | 1 << 7 | 1 << 10}
STOPPED, PLAYING, PAUSED = 1, 2, 4
PLUGGED, SILENT, HUNG_UP = "plugged", "silent", "hung up"
PROTECTED_S = 5.0
STOP_M_S2, EMERGENCY_M_S2 = 2.0, 5.0
LOCKED = (
    "Cannot unlock protective stop until 5s after occurrence. Always inspect cause of protective stop before unlocking"
)


class Safety:
    """The modes of a controller; part of `Controller`, which has the clock and the arm."""

    def switch_on(self) -> None:
        """Powered, brakes released, nothing wrong, remote control, no program."""
        self.robot_mode, self.safety_mode, self.runtime_state = RUNNING, NORMAL, STOPPED
        self.remote, self.line = True, PLUGGED
        self._stopped_s = 0.0

    @property
    def powered(self) -> bool:
        """Whether the arm has power."""
        return self.robot_mode != POWER_OFF

    @property
    def playing(self) -> bool:
        """Whether a program runs."""
        return self.runtime_state == PLAYING

    @property
    def scripted(self) -> bool:
        """Whether a program that comes over the network would run."""
        return self.remote and self.robot_mode == RUNNING and self.safety_mode == NORMAL

    @property
    def safety_bits(self) -> int:
        """Bits of the safety status."""
        return SAFETY_BITS[self.safety_mode]

    def interrupt(self, kind: str) -> None:
        """Bring about what happens in a laboratory.

        "protective", "emergency", "released" (its button is turned), "off", "on" (power and brakes); "program" (a
        person stops it), "pause", "foreign" (somebody else starts one), "local", "remote", "restart" (of the
        controller); "stuck" (moves are taken, but nothing moves), "free"; "hung up" (connections break, none are
        taken), "silent" (nothing comes through, as with a pulled cable), "plugged". Raises ValueError for others.
        """
        actions = {
            "protective": self.protective_stop,
            "emergency": self.emergency_stop,
            "released": self.release,
            "program": self.stop_program,
            "pause": self.pause_program,
            "local": lambda: setattr(self, "remote", False),
            "remote": lambda: setattr(self, "remote", True),
            "off": self.power_off,
            "on": lambda: (self.power_on(), self.release_brakes()),
            "foreign": lambda: setattr(self, "runtime_state", PLAYING),
            "stuck": lambda: setattr(self, "stuck", True),
            "free": lambda: setattr(self, "stuck", False),
            "hung up": lambda: setattr(self, "line", HUNG_UP),
            "silent": lambda: setattr(self, "line", SILENT),
            "restart": self.restart,
            "plugged": lambda: setattr(self, "line", PLUGGED),
        }
        if kind not in actions:
            raise ValueError(f"{kind!r}, expected one of {', '.join(actions)}")
        actions[kind]()
        self.stirred = True

    def protective_stop(self) -> None:
        """As on a collision: the arm halts, the program pauses."""
        if self.safety_mode == NORMAL:
            self.brake(EMERGENCY_M_S2)
            self.safety_mode, self._stopped_s = PROTECTIVE_STOP, self.now_s
            self.runtime_state = PAUSED if self.playing else self.runtime_state

    def unlock(self) -> str:
        """Release a protective stop, as the dashboard does: 5 s after it at the soonest."""
        if self.safety_mode != PROTECTIVE_STOP:
            return "Robot is not in protective stop"
        if self.clock() - self._stopped_s < PROTECTED_S:
            return LOCKED
        self.safety_mode = NORMAL
        return "Protective stop releasing"

    def emergency_stop(self) -> None:
        """The button: the arm halts and loses power, the program ends."""
        self.brake(EMERGENCY_M_S2)
        self.safety_mode, self.robot_mode = ROBOT_EMERGENCY_STOP, POWER_OFF
        self.end_program()

    def release(self) -> None:
        """The button is turned; power stays off."""
        if self.safety_mode == ROBOT_EMERGENCY_STOP:
            self.safety_mode = NORMAL

    def power_off(self) -> None:
        """No power, brakes on."""
        self.brake(EMERGENCY_M_S2)
        self.robot_mode = POWER_OFF
        self.end_program()

    def power_on(self) -> None:
        """Power, brakes still on."""
        if self.safety_mode == NORMAL and self.robot_mode == POWER_OFF:
            self.robot_mode = IDLE

    def release_brakes(self) -> None:
        """Ready to move."""
        if self.safety_mode == NORMAL:
            self.robot_mode = RUNNING

    def stop_program(self) -> None:
        """The program ends, the arm comes to rest."""
        self.brake(STOP_M_S2)
        self.end_program()

    def pause_program(self) -> None:
        """The program pauses, the arm comes to rest."""
        if self.playing:
            self.brake(STOP_M_S2)
            self.runtime_state = PAUSED

    def end_program(self) -> None:
        """No program from now on."""
        self.runtime_state = STOPPED
        self.clear_script()
