(* ---- A linear loop with a root s on the axis or beyond: e^(s t), in discrete time s^t, solves it and has no limit ---- *)

Definition mode (s : C) (k : nat) (t : R) : R :=
  exp (fst s * t) * (fst (cpow s k) * cos (snd s * t) - snd (cpow s k) * sin (snd s * t)).
Definition mode_in_steps (s : C) (t : nat) : R := fst (cpow s t).

Lemma mode_flows : forall s k t, derivable_pt_lim (mode s k) t (mode s (S k) t).
Proof.
  intros [a b] k t; unfold mode; cbn [cpow cmul fst snd]; set (p := fst (cpow (a, b) k)); set (q := snd (cpow (a, b) k)).
  assert (L : forall c, derivable_pt_lim (fun t => c * t) t c).
  { intro c; apply (derivable_same (fun t => c * t) _ t (c * 1)); [reflexivity|ring|].
    apply (derivable_pt_lim_scal id); apply derivable_pt_lim_id. }
  apply (derivable_same (fun t => exp (a * t) * (p * cos (b * t) - q * sin (b * t))) _ t
    (a * exp (a * t) * (p * cos (b * t) - q * sin (b * t))
     + exp (a * t) * (p * (- sin (b * t) * b) - q * (cos (b * t) * b)))); [reflexivity|ring|].
  apply (derivable_pt_lim_mult (fun t => exp (a * t)) (fun t => p * cos (b * t) - q * sin (b * t))).
  - apply exp_flow.
  - apply (derivable_pt_lim_minus (fun t => p * cos (b * t)) (fun t => q * sin (b * t))).
    + apply (derivable_pt_lim_scal (fun t => cos (b * t))).
      apply (derivable_pt_lim_comp (fun t => b * t) cos); [apply L|apply derivable_pt_lim_cos].
    + apply (derivable_pt_lim_scal (fun t => sin (b * t))).
      apply (derivable_pt_lim_comp (fun t => b * t) sin); [apply L|apply derivable_pt_lim_sin].
Qed.

Definition at_time (s v : C) (t : R) : R := exp (fst s * t) * (fst v * cos (snd s * t) - snd v * sin (snd s * t)).
Lemma along_mode : forall s t p acc,
  at_time s (horner acc p s) t = at_time s (cmul acc (cpow s (length p))) t + along p (mode s) t.
Proof.
  intros s t; induction p as [|c p IH]; intro acc; cbn [horner along length cpow].
  - unfold at_time; cbn [cmul fst snd]; ring.
  - rewrite IH; unfold at_time, mode; destruct s as [a b], acc as [x y], (cpow (a, b) (length p)) as [u v].
    cbn [cmul cadd real fst snd]; ring.
Qed.
Lemma mode_closed : forall num den g s, closed num den g s = (0, 0) ->
  forall t, along den (mode s) t = - (g * along num (mode s) t).
Proof.
  intros num den g s E t; pose proof (along_mode s t den (0, 0)) as D; pose proof (along_mode s t num (0, 0)) as N.
  unfold closed in E; fold (poly den s) in D; fold (poly num s) in N.
  destruct (poly den s) as [d1 d2], (poly num s) as [n1 n2]; unfold at_time in D, N.
  cbn [cadd cmul real fst snd] in *; injection E as E1 E2.
  replace d1 with (- (g * n1)) in D by lra; replace d2 with (- (g * n2)) in D by lra.
  apply (f_equal (Rmult g)) in N; lra.
Qed.

Lemma mode_never_settles : forall s, 0 <= fst s -> 0 < snd s \/ (snd s = 0 /\ 0 < fst s) ->
  forall c, ~ tends_to (mode s 0) c.
Proof.
  intros [a b] A [B|[B A']] c lim; cbn [fst snd] in *; destruct (lim 1 ltac:(lra)) as [T H]; unfold mode in H;
    cbn [cpow fst snd] in H.
  - set (n := Z.to_nat (up (Rabs T * b))).
    assert (P : 0 < PI) by apply PI_RGT_0.
    set (t := 2 * INR n * PI / b).
    assert (big : Rabs T * b <= INR n).
    { unfold n; rewrite INR_IZR_INZ, Z2Nat.id.
      - destruct (archimed (Rabs T * b)); lra.
      - apply le_IZR; destruct (archimed (Rabs T * b)) as [U _]; pose proof (Rabs_pos T); nra. }
    assert (late : T <= t).
    { apply Rle_trans with (Rabs T); [apply Rle_abs|]; unfold t; apply (Rmult_le_reg_r b); [exact B|].
      unfold Rdiv; rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra.
      pose proof PI2_1; pose proof (pos_INR n); nra. }
    assert (tpos : 0 <= t).
    { unfold t; apply Rmult_le_pos; [pose proof (pos_INR n); nra|left; now apply Rinv_0_lt_compat]. }
    assert (one : forall u, 0 <= u -> 1 <= exp (a * u)).
    { intros u U; rewrite <- exp_0; destruct (Req_dec (a * u) 0) as [->|N]; [lra|left; apply exp_increasing].
      assert (0 <= a * u) by nra; lra. }
    pose proof (H t ltac:(lra)) as H1; pose proof (H (t + PI / b)) as H2.
    assert (step : 0 < PI / b) by (apply Rdiv_lt_0_compat; lra).
    specialize (H2 ltac:(lra)).
    replace (b * t) with (0 + 2 * INR n * PI) in H1 by (unfold t; field; lra).
    replace (b * (t + PI / b)) with (0 + 2 * INR n * PI + PI) in H2 by (unfold t; field; lra).
    rewrite neg_cos, cos_period, cos_0 in H2; rewrite cos_period, cos_0 in H1.
    pose proof (one t tpos); pose proof (one (t + PI / b) ltac:(lra)).
    apply Rabs_def2 in H1, H2; lra.
  - set (t := Rmax T ((Rabs c + 1) / a)).
    assert (L1 : T <= t) by apply Rmax_l; assert (L2 : (Rabs c + 1) / a <= t) by apply Rmax_r.
    pose proof (H t ltac:(lra)) as H1; rewrite B, Rmult_0_l, cos_0 in H1.
    assert (K : Rabs c + 1 <= a * t).
    { apply Rmult_le_compat_l with (r := a) in L2; [|lra]; replace (a * ((Rabs c + 1) / a)) with (Rabs c + 1) in L2 by (field; lra); exact L2. }
    pose proof (Rabs_pos c); pose proof (Rle_abs c); pose proof (exp_ineq1 (a * t) ltac:(lra)).
    apply Rabs_def2 in H1; lra.
Qed.

Lemma cmul_one : forall a, cmul (1, 0) a = a.
Proof. intros [x y]; unfold cmul; cbn [fst snd]; f_equal; ring. Qed.
Lemma cmul_assoc : forall a b c, cmul a (cmul b c) = cmul (cmul a b) c.
Proof. intros [x y] [u v] [p q]; unfold cmul; cbn [fst snd]; f_equal; ring. Qed.
Lemma shifts_mode : forall s t p acc,
  fst (cmul (horner acc p s) (cpow s t)) = fst (cmul (cmul acc (cpow s (length p))) (cpow s t)) + shifts p (mode_in_steps s) t.
Proof.
  intros s t; induction p as [|c p IH]; intro acc; cbn [horner shifts length cpow].
  - cbn [cmul fst snd]; ring.
  - rewrite IH; unfold mode_in_steps.
    assert (A : forall k, cpow s (k + t) = cmul (cpow s k) (cpow s t)).
    { induction k as [|k K]; cbn [cpow Nat.add]; [now rewrite cmul_one|now rewrite K, cmul_assoc]. }
    rewrite A; destruct s as [a b], acc as [x y], (cpow (a, b) (length p)) as [u v], (cpow (a, b) t) as [e f].
    cbn [cmul cadd real fst snd]; ring.
Qed.
Lemma mode_closed_in_steps : forall num den g s, closed num den g s = (0, 0) ->
  forall t, shifts den (mode_in_steps s) t = - (g * shifts num (mode_in_steps s) t).
Proof.
  intros num den g s E t; pose proof (shifts_mode s t den (0, 0)) as D; pose proof (shifts_mode s t num (0, 0)) as N.
  unfold closed in E; fold (poly den s) in D; fold (poly num s) in N.
  destruct (poly den s) as [d1 d2], (poly num s) as [n1 n2], (cpow s t) as [e f].
  cbn [cadd cmul real fst snd] in *; injection E as E1 E2.
  replace d1 with (- (g * n1)) in D by lra; replace d2 with (- (g * n2)) in D by lra.
  apply (f_equal (Rmult g)) in N; lra.
Qed.
Lemma mode_never_settles_in_steps : forall s, 1 <= square s -> 0 < snd s \/ (snd s = 0 /\ fst s <> 1) ->
  forall c, ~ Un_cv (mode_in_steps s) c.
Proof.
  intros [a b] A B c lim; cbn [fst snd] in *; unfold square in A; cbn [fst snd] in A.
  assert (size : forall t, 1 <= square (cpow (a, b) t)).
  { induction t as [|t IH]; [unfold square; cbn [cpow fst snd]; lra|].
    unfold square in *; cbn [cpow]; destruct (cpow (a, b) t) as [u v]; unfold cmul; cbn [fst snd] in *.
    replace ((a * u - b * v) * (a * u - b * v) + (a * v + b * u) * (a * v + b * u))
      with ((a * a + b * b) * (u * u + v * v)) by ring.
    apply Rle_trans with (1 * 1); [lra|apply Rmult_le_compat; lra]. }
  (* within e of c three times in a row *)
  set (m := (1 - a) * (1 - a) + b * b).
  assert (pos : 0 < m).
  { unfold m; destruct B as [B|[-> B]]; [nra|].
    assert (0 < (1 - a) * (1 - a)); [|lra]; destruct (Rtotal_order a 1) as [N|[N|N]]; [nra|contradiction|nra]. }
  set (K := 1 + 2 * Rabs a + (a * a + b * b)).
  assert (Kpos : 1 <= K) by (unfold K; pose proof (Rabs_pos a); nra).
  assert (zero : c = 0).
  { destruct (Req_dec c 0) as [E|N]; [exact E|exfalso].
    assert (pc : 0 < Rabs c) by now apply Rabs_pos_lt.
    destruct (lim (m * Rabs c / (2 * K)) ltac:(apply Rdiv_lt_0_compat; nra)) as [T H].
    pose proof (H T ltac:(lia)) as H0; pose proof (H (S T) ltac:(lia)) as H1; pose proof (H (S (S T)) ltac:(lia)) as H2.
    unfold R_dist, mode_in_steps in *; cbn [cpow cmul fst snd] in *; destruct (cpow (a, b) T) as [u v]; cbn [fst snd] in *.
    set (e := m * Rabs c / (2 * K)) in *.
    set (x0 := u - c) in *; set (x1 := a * u - b * v - c) in *.
    set (x2 := a * (a * u - b * v) - b * (a * v + b * u) - c) in *.
    assert (E : m * c = - (x2 - 2 * a * x1 + (a * a + b * b) * x0)) by (unfold m, x0, x1, x2; ring).
    assert (F : m * Rabs c < K * e).
    { replace (m * Rabs c) with (Rabs (m * c)) by (rewrite Rabs_mult, (Rabs_right m) by lra; reflexivity).
      rewrite E, Rabs_Ropp.
      apply Rle_lt_trans with (1 := Rabs_triang _ _).
      apply Rle_lt_trans with (Rabs x2 + Rabs (2 * a * x1) + Rabs ((a * a + b * b) * x0)).
      { apply Rplus_le_compat_r; unfold Rminus; apply Rle_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp; lra. }
      rewrite !Rabs_mult, (Rabs_right 2), (Rabs_right (a * a + b * b)) by nra.
      unfold K; pose proof (Rabs_pos a); pose proof (Rabs_pos x0); pose proof (Rabs_pos x1); nra. }
    assert (G : K * e = m * Rabs c / 2) by (unfold e; field; lra); nra. }
  subst c; destruct B as [B|[-> B]].
  - set (L := 1 + (Rabs a + 1) / b).
    assert (q : 0 < (Rabs a + 1) / b) by (apply Rdiv_lt_0_compat; [pose proof (Rabs_pos a); lra|exact B]).
    destruct (lim (1 / (2 * L)) ltac:(apply Rdiv_lt_0_compat; unfold L; lra)) as [T H].
    pose proof (H T ltac:(lia)) as H0; pose proof (H (S T) ltac:(lia)) as H1; pose proof (size T) as S0.
    unfold R_dist, mode_in_steps, square in *; cbn [cpow cmul fst snd] in *; destruct (cpow (a, b) T) as [u v]; cbn [fst snd] in *.
    rewrite Rminus_0_r in *; set (e := 1 / (2 * L)) in *.
    assert (V : Rabs v < (Rabs a + 1) / b * e).
    { apply (Rmult_lt_reg_l b); [exact B|].
      replace (b * ((Rabs a + 1) / b * e)) with (Rabs a * e + e) by (field; lra).
      replace (b * Rabs v) with (Rabs (a * u + - (a * u - b * v))).
      - apply Rle_lt_trans with (1 := Rabs_triang _ _); rewrite Rabs_Ropp, Rabs_mult; pose proof (Rabs_pos a); nra.
      - replace (a * u + - (a * u - b * v)) with (b * v) by ring; rewrite Rabs_mult, (Rabs_right b) by lra; reflexivity. }
    assert (E : L * e = 1 / 2) by (unfold e; field; unfold L; lra).
    assert (U : Rabs u + Rabs v < 1 / 2) by (rewrite <- E; unfold L; lra).
    pose proof (Rabs_pos u); pose proof (Rabs_pos v).
    assert (u * u = Rabs u * Rabs u) by (rewrite <- Rabs_mult, Rabs_right by nra; reflexivity).
    assert (v * v = Rabs v * Rabs v) by (rewrite <- Rabs_mult, Rabs_right by nra; reflexivity).
    nra.
  - destruct (lim 1 ltac:(lra)) as [T H]; pose proof (H T ltac:(lia)) as H0; pose proof (size T) as S0.
    assert (flat : forall t, snd (cpow (a, 0) t) = 0).
    { induction t as [|t IH]; [reflexivity|]; cbn [cpow cmul fst snd]; rewrite IH; ring. }
    unfold R_dist, mode_in_steps, square in *; rewrite flat in S0; rewrite Rminus_0_r in H0; apply Rabs_def2 in H0; nra.
Qed.

(* A simple root where constants are solutions: they have a limit, which is not 0. *)
Lemma mode_rests : ~ tends_to (mode (0, 0) 0) 0.
Proof.
  intro lim; destruct (lim 1 ltac:(lra)) as [T H]; specialize (H T ltac:(lra)); unfold mode in H; cbn [cpow fst snd] in H.
  rewrite !Rmult_0_l, exp_0, cos_0 in H; apply Rabs_def2 in H; lra.
Qed.
Lemma mode_rests_in_steps : ~ Un_cv (mode_in_steps (1, 0)) 0.
Proof.
  assert (one : forall t, cpow (1, 0) t = (1, 0)).
  { induction t as [|t IH]; [reflexivity|]; cbn [cpow]; rewrite IH; apply cmul_one. }
  intro lim; destruct (lim 1 ltac:(lra)) as [T H]; specialize (H T ltac:(lia)); unfold R_dist, mode_in_steps in H.
  rewrite one in H; cbn [fst] in H; apply Rabs_def2 in H; lra.
Qed.

(* A double root there: t and its derivative. *)
Definition line (k : nat) (t : R) : R := match k with O => t | S O => 1 | _ => 0 end.
Lemma line_flows : forall k t, derivable_pt_lim (line k) t (line (S k) t).
Proof.
  intros [|[|k]] t; [exact (derivable_pt_lim_id t)|exact (derivable_pt_lim_const 1 t)|exact (derivable_pt_lim_const 0 t)].
Qed.
Lemma line_never_settles : forall c, ~ tends_to (line 0) c.
Proof.
  intros c lim; destruct (lim 1 ltac:(lra)) as [T H]; pose proof (Rmax_l T (c + 1)); pose proof (Rmax_r T (c + 1)).
  specialize (H (Rmax T (c + 1)) ltac:(lra)); unfold line in H; apply Rabs_def2 in H; lra.
Qed.
Lemma line_never_settles_in_steps : forall c, ~ Un_cv INR c.
Proof.
  intros c lim; destruct (lim (1 / 4) ltac:(lra)) as [T H]; pose proof (H T ltac:(lia)) as A.
  specialize (H (S T) ltac:(lia)); rewrite S_INR in H; unfold R_dist in *; apply Rabs_def2 in A, H; lra.
Qed.

(* ---- The gain for which s is a root, and its place by a change of sign ---- *)

Definition at_root (d n : C) : R := - fst (cmul d (conj_ n)) / square n.
Lemma root_with_gain : forall d n, 0 < square n -> snd (cmul d (conj_ n)) = 0 -> cadd d (cmul (real (at_root d n)) n) = (0, 0).
Proof.
  intros [d1 d2] [n1 n2] pos E; unfold at_root, square, conj_, cadd, cmul, real in *; cbn [fst snd] in *.
  assert (E' : d2 * n1 = d1 * n2) by lra; apply injective_projections; cbn [fst snd];
    apply (Rmult_eq_reg_l (n1 * n1 + n2 * n2)); try lra; rewrite Rmult_0_r.
  - transitivity (n2 * (d1 * n2 - d2 * n1)); [field; lra|rewrite E'; ring].
  - transitivity (n1 * (d2 * n1 - d1 * n2)); [field; lra|rewrite E'; ring].
Qed.

Fixpoint least (p : list Z) : Z := match p with a :: p' => a + Z.min 0 (least p') | [] => 0 end.
Lemma least_sound : forall p x, 0 <= x <= 1 -> IZR (least p) <= peval p x.
Proof.
  induction p as [|a p IH]; intros x X; cbn [least peval]; [lra|]; rewrite plus_IZR; specialize (IH x X).
  destruct (Z.min_spec 0 (least p)) as [[L E]|[L E]]; rewrite E.
  - apply IZR_lt in L; nra.
  - apply IZR_le in L; nra.
Qed.
Lemma above_0 : forall p x, (0 <? least p)%Z = true -> 0 <= x <= 1 -> 0 < peval p x.
Proof. intros p x H X; apply Z.ltb_lt, IZR_lt in H; pose proof (least_sound p x X); lra. Qed.
Lemma peval_continuous : forall p, continuity (peval p).
Proof.
  induction p as [|a p IH]; [apply continuity_const; intros x y; reflexivity|].
  apply (continuity_plus (fun _ => IZR a) (fun x => x * peval p x)); [apply continuity_const; intros x y; reflexivity|].
  apply (continuity_mult id (peval p)); [apply derivable_continuous, derivable_id|exact IH].
Qed.
Lemma peval_ends : forall p, peval p 0 = IZR (hd 0%Z p) /\ peval p 1 = IZR (fold_right Z.add 0%Z p).
Proof.
  split; [destruct p; cbn [peval hd]; ring|].
  induction p as [|a p IH]; cbn [peval fold_right]; [reflexivity|]; rewrite plus_IZR, <- IH; ring.
Qed.
Lemma a_zero : forall p, (hd 0 p * fold_right Z.add 0 p <=? 0)%Z = true -> exists x, 0 <= x <= 1 /\ peval p x = 0.
Proof.
  intros p H; apply Z.leb_le, IZR_le in H; rewrite mult_IZR in H; destruct (peval_ends p) as [A B].
  destruct (IVT_cor (peval p) 0 1 (peval_continuous p)) as [x [X E]]; [lra|rewrite A, B; lra|]; exists x; auto.
Qed.
Lemma gain_above : forall q l d n, 0 < q -> 0 < square n -> 0 < q * (- fst (cmul d (conj_ n)) - l * square n) -> l <= at_root d n.
Proof.
  intros q l d n Q pos H; unfold at_root; apply (Rmult_le_reg_r (square n)); [exact pos|].
  unfold Rdiv; rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra.
  assert (0 < - fst (cmul d (conj_ n)) - l * square n) by (apply (Rmult_lt_reg_l q); lra); lra.
Qed.
Lemma gain_below : forall q u d n, 0 < q -> 0 < square n -> 0 < q * (u * square n + fst (cmul d (conj_ n))) -> at_root d n <= u.
Proof.
  intros q u d n Q pos H; unfold at_root; apply (Rmult_le_reg_r (square n)); [exact pos|].
  unfold Rdiv; rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra.
  assert (0 < u * square n + fst (cmul d (conj_ n))) by (apply (Rmult_lt_reg_l q); lra); lra.
Qed.
