(* ---- Gains that repeat, in discrete time: x'Q_i x falls at each step, and is negative at the start ---- *)

(* The samples from t on, and one later, of den xi = - g num xi: the highest coefficient first, of both as many. *)
Fixpoint last_dot (p : list R) (s : list R) : R :=
  match p with c :: r => c * nth (length r) s 0 + last_dot r s | [] => 0 end.
Definition step (num den : list R) (g : R) (s : list R) : list R :=
  tl s ++ [- (last_dot (tl den) s + g * last_dot (tl num) s) / (hd 0 den + g * hd 0 num)].
Fixpoint run (num den : list R) (gain_at : nat -> R) (start : list R) (t : nat) : list R :=
  match t with O => start | S k => step num den (gain_at k) (run num den gain_at start k) end.
Definition sampled (num den : list R) (gain_at : nat -> R) (start : list R) (t : nat) : R :=
  nth 0 (run num den gain_at start t) 0.

Lemma step_length : forall num den g s, s <> [] -> length (step num den g s) = length s.
Proof. intros num den g [|x s] N; [contradiction|]; unfold step; rewrite app_length; cbn; lia. Qed.
Lemma run_length : forall num den f start t, start <> [] -> length (run num den f start t) = length start.
Proof.
  intros num den f start t N; induction t as [|t IH]; [reflexivity|]; cbn [run].
  rewrite step_length; [exact IH|]; intro E; rewrite E in IH; destruct start; [contradiction|discriminate].
Qed.
Lemma nth_run : forall num den f start t k, start <> [] -> (k < length start)%nat ->
  nth k (run num den f start t) 0 = sampled num den f start (k + t).
Proof.
  intros num den f start t k N; revert t; induction k as [|k IH]; intros t L; [reflexivity|].
  replace (S k + t)%nat with (k + S t)%nat by lia; rewrite <- IH by lia; cbn [run]; unfold step.
  pose proof (run_length num den f start t N) as E.
  destruct (run num den f start t) as [|x s]; cbn [length tl nth] in *; [lia|]; now rewrite app_nth1 by lia.
Qed.
Lemma last_run : forall num den f start t p, start <> [] -> (length p <= length start)%nat ->
  last_dot p (run num den f start t) = shifts p (sampled num den f start) t.
Proof.
  intros num den f start t p N; induction p as [|c p IH]; intro L; [reflexivity|]; cbn [length last_dot shifts] in *.
  now rewrite nth_run, IH by (assumption || lia).
Qed.
Lemma run_solves : forall num den f start t, start <> [] -> length den = S (length start) -> length num = length den ->
  hd 0 den + f t * hd 0 num <> 0 ->
  shifts den (sampled num den f start) t = - (f t * shifts num (sampled num den f start) t).
Proof.
  intros [|n num] [|d den] f start t N L M posed; try discriminate; cbn [hd] in posed; cbn [length] in L, M.
  injection L as L; injection M as M; cbn [shifts]; rewrite M, L.
  assert (E : sampled (n :: num) (d :: den) f start (length start + t)
    = - (last_dot den (run (n :: num) (d :: den) f start t) + f t * last_dot num (run (n :: num) (d :: den) f start t))
      / (d + f t * n)).
  { destruct start as [|x start]; [contradiction|]; cbn [length].
    replace (S (length start) + t)%nat with (length start + S t)%nat by lia.
    rewrite <- nth_run by (cbn [length]; lia || discriminate); cbn [run]; unfold step; cbn [tl hd].
    pose proof (run_length (n :: num) (d :: den) f (x :: start) t ltac:(discriminate)) as E.
    destruct (run (n :: num) (d :: den) f (x :: start) t) as [|y s]; cbn [length] in E; [lia|]; cbn [tl].
    rewrite app_nth2 by lia; replace (length start - length s)%nat with O by lia; reflexivity. }
  rewrite E, !last_run by (assumption || lia); field; exact posed.
Qed.

(* One step: d times the samples, d times those one later, and Q. *)
Definition growth_step (n : nat) (N K : Z) (now next : list (list Z)) (Q after : list (list Z)) : bool :=
  nonneg n (times N (bilinear Q now now ++ times (-1) (bilinear after next next)) ++ times (-1) (squares now)) &&
  nonneg n (bilinear Q now now ++ times K (squares now)).

Lemma grows_without_end : forall (Q : nat -> list (list Z)) (x : nat -> list R) N K, 0 < N -> 0 < K ->
  (forall t, norm2 (x t) <= N * (V (Q t) (x t) - V (Q (S t)) (x (S t)))) ->
  (forall t, 0 <= V (Q t) (x t) + K * norm2 (x t)) -> V (Q O) (x O) < 0 ->
  forall B, ~ (forall t, norm2 (x t) <= B).
Proof.
  intros Q x N K Np Kp falls low start B bound; set (v := fun t => V (Q t) (x t)) in *; change (v O < 0) in start.
  set (e := - v O / (N * K)); assert (epos : 0 < e) by (apply Rdiv_lt_0_compat; [lra|nra]).
  assert (down : forall t, v t <= v O - INR t * e /\ v t <= v O).
  { induction t as [|t [IH IH']]; [cbn; lra|]; rewrite S_INR.
    pose proof (falls t) as F; fold (v t) in F; fold (v (S t)) in F; pose proof (low t) as L; fold (v t) in L.
    assert (G : N * K * e = - v O) by (unfold e; field; lra).
    assert (H : e <= v t - v (S t)).
    { apply (Rmult_le_reg_l (N * K)); [nra|]; rewrite G.
      assert (K * norm2 (x t) <= K * (N * (v t - v (S t)))) by (apply Rmult_le_compat_l; lra); lra. }
    split; lra. }
  destruct (archimed (K * B / e)) as [A _]; set (t := Z.to_nat (up (K * B / e))) in *.
  assert (B0 : 0 <= B).
  { apply Rle_trans with (2 := bound O); clear; induction (x O) as [|y z IH]; cbn; nra. }
  assert (T : K * B / e < INR t).
  { unfold t; rewrite INR_IZR_INZ, Z2Nat.id; [exact A|].
    apply le_IZR; apply Rle_trans with (K * B / e); [|lra].
    apply Rmult_le_pos; [nra|left; now apply Rinv_0_lt_compat]. }
  pose proof (proj1 (down t)); pose proof (low t) as L; fold (v t) in L; pose proof (bound t).
  assert (K * B < INR t * e).
  { clearbody t e; apply (Rmult_lt_compat_r e) in T; [|exact epos].
    replace (K * B / e * e) with (K * B) in T by (field; lra); exact T. }
  assert (K * norm2 (x t) <= K * B) by (apply Rmult_le_compat_l; lra); lra.
Qed.
Lemma converging_bounded : forall (u : nat -> R) c, Un_cv u c -> exists B, forall t, Rabs (u t) <= B.
Proof.
  intros u c H; destruct (maj_by_pos u (exist _ c H)) as [B [_ L]]; exists B; intro t; apply L.
Qed.
Lemma never_settles_switched : forall num den f start, start <> [] ->
  (forall B, ~ (forall t, norm2 (run num den f start t) <= B)) -> forall c, ~ Un_cv (sampled num den f start) c.
Proof.
  intros num den f start some endless c lim.
  destruct (converging_bounded _ c lim) as [B H].
  apply (endless (INR (length start) * (B * B))); intro t.
  assert (E : forall k, (k < length start)%nat -> Rabs (nth k (run num den f start t) 0) <= B).
  { intros k L; rewrite nth_run by assumption; apply H. }
  rewrite <- (run_length num den f start t some) in *; revert E; generalize (run num den f start t); clear.
  induction l as [|y z IH]; intro E; [cbn; lra|]; cbn [norm2 length]; rewrite S_INR.
  pose proof (E O ltac:(cbn; lia)) as Y; cbn [nth] in Y.
  specialize (IH (fun k L => E (S k) ltac:(cbn; lia))); pose proof (Rabs_pos y).
  assert (y * y <= B * B); [|lra].
  rewrite <- (Rabs_right (y * y)), Rabs_mult by nra; nra.
Qed.

(* Of each step: d, the rows of d times the samples one later, and Q. *)
Definition phase := (Z * (list (list Z) * list (list Z)))%type.
Definition scaled_units (n : nat) (d : Z) : list (list Z) := map (fun i => repeat 0%Z i ++ [d]) (seq 0 n).
Definition phase_at (ps : list phase) (t : nat) : phase := nth (t mod length ps) ps (1%Z, ([], [])).
Definition grows (n : nat) (N K : Z) (ps : list phase) : bool :=
  (0 <? N)%Z && (0 <? K)%Z &&
  forallb (fun i => let '(d, (next, Q)) := phase_at ps i in
    (0 <? d)%Z && growth_step n N K (scaled_units n d) next Q (snd (snd (phase_at ps (S i))))) (seq 0 (length ps)).

Lemma at_scaled_units : forall n d z, length z = n -> at_ (scaled_units n d) z = map (Rmult (IZR d)) z.
Proof.
  intros n d z <-; unfold at_, scaled_units; rewrite map_map.
  rewrite (map_ext _ (fun i => IZR d * nth i z 0)) by (intro; apply dot_place).
  induction z as [|x z IH]; [reflexivity|]; cbn [length seq map nth]; f_equal.
  rewrite <- seq_shift, map_map; exact IH.
Qed.
Lemma phase_mod : forall ps t, ps <> [] -> phase_at ps (S (t mod length ps)) = phase_at ps (S t).
Proof.
  intros ps t some; unfold phase_at; f_equal; change (S (t mod length ps)) with (1 + t mod length ps)%nat.
  rewrite Nat.add_mod_idemp_r; [reflexivity|destruct ps; [contradiction|discriminate]].
Qed.

Lemma growing : forall n (x : nat -> list R) N K ps, ps <> [] -> grows n N K ps = true -> (forall t, length (x t) = n) ->
  (forall t, let '(d, (next, _)) := phase_at ps t in at_ next (x t) = map (Rmult (IZR d)) (x (S t))) ->
  V (snd (snd (phase_at ps 0))) (x O) < 0 -> forall B, ~ (forall t, norm2 (x t) <= B).
Proof.
  intros n x N K ps phases test L steps_ neg; unfold grows in test.
  rewrite !andb_true_iff, !Z.ltb_lt, forallb_forall in test; destruct test as [[Np Kp] test]; apply IZR_lt in Np, Kp.
  assert (each : forall t,
    norm2 (x t) <= IZR N * (V (snd (snd (phase_at ps t))) (x t) - V (snd (snd (phase_at ps (S t)))) (x (S t))) /\
    0 <= V (snd (snd (phase_at ps t))) (x t) + IZR K * norm2 (x t)).
  { intro t; pose proof (steps_ t) as S0; specialize (L t).
    assert (I : In (t mod length ps) (seq 0 (length ps))).
    { apply in_seq; split; [lia|]; apply Nat.mod_upper_bound; destruct ps; [contradiction|discriminate]. }
    specialize (test _ I); rewrite phase_mod in test by exact phases.
    replace (phase_at ps (t mod length ps)) with (phase_at ps t) in test
      by (unfold phase_at; rewrite Nat.mod_mod; [reflexivity|destruct ps; [contradiction|discriminate]]).
    destruct (phase_at ps t) as [d [next Q]]; cbn [snd].
    rewrite andb_true_iff, Z.ltb_lt in test; destruct test as [dp test]; apply IZR_lt in dp.
    unfold growth_step in test; apply andb_true_iff in test as [A B].
    pose proof (nonneg_sound _ _ (x t) A L) as C; pose proof (nonneg_sound _ _ (x t) B L) as D.
    repeat (rewrite value_app in C || rewrite value_times in C || rewrite value_app in D || rewrite value_times in D).
    rewrite !value_bilinear in C; rewrite value_bilinear in D; rewrite squares_at in C, D.
    fold (V Q (at_ (scaled_units n d) (x t))) in C, D.
    rewrite (at_scaled_units _ _ _ L) in C, D; rewrite S0 in C.
    fold (V (snd (snd (phase_at ps (S t)))) (map (Rmult (IZR d)) (x (S t)))) in C.
    rewrite !V_scaled, norm2_scaled in C; rewrite V_scaled, norm2_scaled in D.
    set (v := V Q (x t)) in *; set (w := V _ (x (S t))) in *; set (m := norm2 (x t)) in *.
    assert (d2 : 0 < IZR d * IZR d) by nra.
    split; apply (Rmult_le_reg_l (IZR d * IZR d)); try exact d2; lra. }
  apply (grows_without_end (fun t => snd (snd (phase_at ps t))) x (IZR N) (IZR K)); try assumption; intro t; apply each.
Qed.
Theorem switched : forall num den f start N K ps, start <> [] -> ps <> [] -> grows (length start) N K ps = true ->
  (forall t s, length s = length start ->
    let '(d, (next, _)) := phase_at ps t in at_ next s = map (Rmult (IZR d)) (step num den (f t) s)) ->
  V (snd (snd (phase_at ps 0))) start < 0 -> forall c, ~ Un_cv (sampled num den f start) c.
Proof.
  intros num den f start N K ps some phases test steps_ neg; apply (never_settles_switched num den f start some).
  apply (growing (length start) (run num den f start) N K ps); try assumption; intro t;
    [|apply (steps_ t)]; now apply run_length.
Qed.

(* The same of states. *)
Theorem turned : forall n N K ps start, ps <> [] -> length start = n -> grows n N K ps = true ->
  forallb (fun phase => (length (fst (snd phase)) =? n)%nat) ps = true -> V (snd (snd (phase_at ps 0))) start < 0 ->
  exists x : nat -> nat -> R,
    (forall k t, (k < n)%nat -> let phase := phase_at ps t in
      x k (S t) = dot (nth k (fst (snd phase)) []) (listed n (fun i => x i t)) / IZR (fst phase)) /\
    (forall B, ~ (forall t, norm2 (listed n (fun i => x i t)) <= B)).
Proof.
  intros n N K ps start some L test shape neg.
  set (state := fix state (t : nat) : list R := match t with
    | O => start
    | S k => let phase := phase_at ps k in map (fun y => y / IZR (fst phase)) (at_ (fst (snd phase)) (state k)) end).
  assert (I : forall t, In (phase_at ps t) ps).
  { intro t; unfold phase_at; apply nth_In, Nat.mod_upper_bound; destruct ps; [contradiction|discriminate]. }
  rewrite forallb_forall in shape.
  assert (rows : forall t, length (fst (snd (phase_at ps t))) = n) by (intro t; apply Nat.eqb_eq, shape, I).
  assert (Ls : forall t, length (state t) = n).
  { intros [|t]; [exact L|]; cbn [state]; unfold at_; now rewrite !map_length. }
  assert (same_ : forall t, listed n (fun i => nth i (state t) 0) = state t).
  { intro t; rewrite <- (Ls t) at 1; apply listed_again. }
  assert (nz : forall t, IZR (fst (phase_at ps t)) <> 0).
  { intros t E; unfold grows in test; rewrite andb_true_iff, forallb_forall in test; destruct test as [_ test].
    specialize (test (t mod length ps)%nat); rewrite in_seq in test; unfold phase_at in *.
    rewrite Nat.mod_mod in test by (destruct ps; [contradiction|discriminate]).
    destruct (nth (t mod length ps) ps (1%Z, ([], []))) as [d [next Q]]; cbn [fst] in E.
    assert (P : (0 < d)%Z); [|apply IZR_lt in P; lra].
    rewrite andb_true_iff, Z.ltb_lt in test; apply test; split; [lia|].
    apply Nat.mod_upper_bound; destruct ps; [contradiction|discriminate]. }
  exists (fun k t => nth k (state t) 0); split.
  - intros k t Kn phase; rewrite same_; cbn [state]; fold phase; unfold at_; rewrite map_map.
    rewrite <- (rows t) in Kn; fold phase in Kn; revert Kn; generalize (fst (snd phase)); clear; intros l; revert k.
    induction l as [|row l IH]; intros [|k] Kn; cbn in Kn |- *; try lia; [reflexivity|]; apply IH; lia.
  - intros B H; apply (growing n state N K ps some test Ls) with (B := B); [|exact neg|].
    + intro t; specialize (nz t); cbn [state]; destruct (phase_at ps t) as [d [next Q]]; cbn [fst snd] in *.
      rewrite map_map; rewrite <- (map_id (at_ next (state t))) at 1; apply map_ext; intro y; field; exact nz.
    + intro t; rewrite <- (same_ t); apply H.
Qed.
